#include <oncollide/scenes/files/mesh/welder.hpp>

#include <algorithm>
#include <array>
#include <bit>

namespace oncollide {

namespace {

constexpr std::uint32_t none = 0xffffffffu;
constexpr std::size_t least_slots = 64, recent_slots = std::size_t{1} << 15;

std::uint32_t hash_of(const Eigen::Vector3d& p)
{
    // + 0.0: makes the two zeros equal.
    const std::uint64_t hash = std::bit_cast<std::uint64_t>(p.x() + 0.0) * 0x9E3779B97F4A7C15u +
                               std::bit_cast<std::uint64_t>(p.y() + 0.0) * 0xC2B2AE3D27D4EB4Fu +
                               std::bit_cast<std::uint64_t>(p.z() + 0.0) * 0x165667B19E3779F9u;
    return static_cast<std::uint32_t>((hash ^ hash >> 29) * 0xBF58476D1CE4E5B9u >> 32);
}

} // namespace

void Welder::make_slots(std::size_t count)
{
    LargeVector<Slot> old(count, Slot{0, none});
    std::swap(old, slots_);
    for (const Slot& slot : old) {
        if (slot.number == none) continue;
        std::size_t at = slot.hash & (count - 1);
        while (slots_[at].number != none) at = (at + 1) & (count - 1);
        slots_[at] = slot;
    }
}

std::uint32_t Welder::find_or_add(const Eigen::Vector3d& point, std::uint32_t hash)
{
    const std::size_t mask = slots_.size() - 1;
    std::size_t at = hash & mask;
    while (slots_[at].number != none && (slots_[at].hash != hash || points_[slots_[at].number] != point))
        at = (at + 1) & mask;
    if (slots_[at].number == none) {
        slots_[at] = {hash, static_cast<std::uint32_t>(points_.size())};
        append_large(points_, point);
    }
    return slots_[at].number;
}

void Welder::add(std::span<const Eigen::Vector3d> points, std::uint32_t* numbers)
{
    constexpr std::size_t batch = 48;
    std::array<std::uint32_t, batch> hashes;
    if (recent_.empty()) recent_.assign(recent_slots, Slot{0, none});
    while (!points.empty()) {
        const std::size_t count = std::min(batch, points.size());
        while (8 * (points_.size() + count) > 5 * slots_.size()) make_slots(std::max(least_slots, 2 * slots_.size()));
        for (std::size_t i = 0; i < count; ++i) {
            hashes[i] = hash_of(points[i]);
            __builtin_prefetch(&slots_[hashes[i] & (slots_.size() - 1)]);
        }
        for (std::size_t i = 0; i < count; ++i) {
            Slot& recent = recent_[hashes[i] >> 17];
            if (recent.number == none || recent.hash != hashes[i] || points_[recent.number] != points[i])
                recent = {hashes[i], find_or_add(points[i], hashes[i])};
            *numbers++ = recent.number;
        }
        points = points.subspan(count);
    }
}

} // namespace oncollide
