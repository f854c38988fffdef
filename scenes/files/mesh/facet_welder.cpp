#include <oncollide/scenes/files/mesh/facet_welder.hpp>

#include <algorithm>
#include <bit>
#include <cstring>

#include <oncollide/base/simd/prefetch.hpp>

namespace oncollide {

namespace {

static_assert(std::endian::native == std::endian::little, "keys are cut out of the file");

constexpr std::size_t slots_a_line = 16, least_facet_slots = 64, most_recent_lines = std::size_t{1} << 13;
constexpr std::uint64_t no_key = 0x8000000080000000u; // -0 twice, which no key contains

Eigen::Vector3d point_at(const char* corner)
{
    Eigen::Vector3f point;
    std::memcpy(point.data(), corner, sizeof point);
    return point.cast<double>();
}

bool is_same(const Eigen::Vector3d& a, const Eigen::Vector3d& b) // with a single branch
{
    return (int{a.x() == b.x()} & int{a.y() == b.y()} & int{a.z() == b.z()}) != 0;
}

} // namespace

FacetWelder::FacetWelder(std::size_t facets) : corners_(3 * batch), missing_(3 * batch), found_(3 * batch + 1)
{
    // A closed surface has half as many points as triangles, an open one a few more; for unconnected triangles the
    // buffers grow. The system provides untouched pages only on use.
    reserve_large(points_, facets / 2 + facets / 16 + 3 * batch);
    make_slots(std::bit_ceil(std::max(least_facet_slots, facets / 2 * 8 / 5)));
    const std::size_t lines = std::bit_ceil(std::clamp<std::size_t>(facets / 4, 2, most_recent_lines));
    RecentLine empty;
    empty.entries.fill({{no_key, 0}, 0});
    recent_.assign(lines, empty);
    recent_shift_ = 64 - std::countr_zero(lines);
}

inline bool FacetWelder::RecentLine::bring_forward(const Key& key)
{
    std::size_t place = 0; // without branches, which would be mispredicted
    for (std::size_t i = 1; i < entries.size(); ++i) place += i * std::size_t{entries[i].key == key};
    std::swap(entries[0], entries[place]);
    return place > 0;
}

inline void FacetWelder::RecentLine::insert(const Recent& entry)
{
    entries = {entry, entries[0], entries[1], entries[2]};
}

inline FacetWelder::Key FacetWelder::key_at(const char* corner)
{
    using F32x4 = float __attribute__((vector_size(16)));
    using U64x2 = std::uint64_t __attribute__((vector_size(16)));
    F32x4 point;
    std::memcpy(&point, corner, sizeof point);
    point += 0.0f; // -0 becomes 0
    const auto bits = reinterpret_cast<U64x2>(point);
    return {bits[0], static_cast<std::uint32_t>(bits[1])};
}

inline std::uint64_t FacetWelder::hash_of(const Key& key)
{
    const std::uint64_t hash = key.xy * 0x9E3779B97F4A7C15u + key.z * 0xC2B2AE3D27D4EB4Fu;
    return (hash ^ hash >> 29) * 0xBF58476D1CE4E5B9u;
}

inline std::uint32_t FacetWelder::tag_of(std::uint64_t hash) const
{
    return static_cast<std::uint32_t>(hash) & ~mask_;
}

/// Position of the slot with the hash's tag whose number satisfies `is_it`, or of the empty slot to use: in the same
/// cache line, unless it is full.
template <class IsIt>
inline std::size_t FacetWelder::place_of(std::uint64_t hash, IsIt is_it) const
{
    const std::uint32_t tag = tag_of(hash);
    const std::size_t home = hash >> 32;
    for (std::size_t line = home & mask_ & ~(slots_a_line - 1);; line = (line + slots_a_line) & mask_)
        for (std::size_t i = home; i < home + slots_a_line; ++i) {
            const std::size_t place = line + i % slots_a_line;
            const std::uint32_t slot = slots_[place];
            if (slot == 0 || (((slot - 1) & ~mask_) == tag && is_it((slot - 1) & mask_))) return place;
        }
}

void FacetWelder::make_slots(std::size_t count)
{
    slots_ = LargeVector<std::uint32_t>();
    slots_.resize(count);
    mask_ = static_cast<std::uint32_t>(count - 1);
    for (std::uint32_t i = 0; i < points_.size(); ++i) {
        const Eigen::Vector3f point = points_[i].cast<float>();
        char corner[sizeof point + sizeof(float)] = {};
        std::memcpy(corner, point.data(), sizeof point);
        const std::uint64_t hash = hash_of(key_at(corner));
        slots_[place_of(hash, [](std::uint32_t) { return false; })] = (i | tag_of(hash)) + 1;
    }
}

/// Computes the corners' keys, and prefetches their entries in recent_.
void FacetWelder::take_apart(const char* facets, std::size_t count)
{
    Corner* next = corners_.data();
    // Local variables stay in registers; members would be reloaded after each write.
    const RecentLine* const recent = recent_.data();
    const int shift = recent_shift_;
    for (const char* facet = facets; facet != facets + count * facet_bytes; facet += facet_bytes)
        for (const char* corner = facet + corners_at; corner != facet + corners_at + 36; corner += 12) {
            const Key key = key_at(corner);
            const std::uint64_t hash = hash_of(key);
            prefetch(&recent[hash >> shift]);
            *next++ = {key, hash};
        }
}

/// Numbers the corners; numbers corners that are not in recent_ as new, and returns their count.
std::uint32_t FacetWelder::look_among_recent(std::size_t corners, std::uint32_t* numbers)
{
    const auto first_new = static_cast<std::uint32_t>(points_.size());
    const Corner* const all = corners_.data();
    RecentLine* const lines = recent_.data();
    const int shift = recent_shift_;
    const std::uint32_t* const slots = slots_.data();
    const std::uint64_t mask = mask_;
    std::uint32_t* const indices = missing_.data();
    std::uint32_t missing = 0;
    for (std::uint32_t i = 0; i < corners; ++i) {
        const Corner& corner = all[i];
        RecentLine& recent = lines[corner.hash >> shift];
        if (!recent.begins_with(corner.key) && !recent.bring_forward(corner.key)) {
            recent.insert({corner.key, first_new + missing});
            indices[missing++] = i;
            prefetch(&slots[corner.hash >> 32 & mask]);
        }
        numbers[i] = recent.entries[0].number;
    }
    return missing;
}

/// Prefetches the points that probably match.
void FacetWelder::fetch_points(std::size_t missing) const
{
    for (std::size_t i = 0; i < missing; ++i) {
        const std::uint32_t slot = slots_[place_of(corners_[missing_[i]].hash, [](std::uint32_t) { return true; })];
        if (slot != 0) prefetch_all_of(points_[(slot - 1) & mask_]);
    }
}

bool FacetWelder::add(const char* facets, std::size_t count, Triangle* triangles)
{
    const std::size_t corners = 3 * count;
    while (8 * (points_.size() + corners) > 5 * slots_.size()) make_slots(2 * slots_.size());
    const auto first_new = static_cast<std::uint32_t>(points_.size());
    take_apart(facets, count);
    const std::uint32_t missing = look_among_recent(corners, triangles->data());
    if (many_known_) fetch_points(missing);
    if (first_new + missing > points_.capacity()) reserve_large(points_, 2 * (first_new + missing));
    for (std::size_t i = 0; i < missing; ++i) {
        const std::size_t corner = missing_[i];
        const Eigen::Vector3d point = point_at(facets + corner / 3 * facet_bytes + corners_at + corner % 3 * 12);
        if (!point.allFinite()) return false;
        const std::uint64_t hash = corners_[corner].hash;
        const auto is_it = [&](std::uint32_t number) { return is_same(points_[number], point); };
        std::uint32_t& slot = slots_[place_of(hash, is_it)];
        if (slot == 0) {
            slot = (static_cast<std::uint32_t>(points_.size()) | tag_of(hash)) + 1;
            points_.emplace_back(point.x(), point.y(), point.z());
        }
        found_[i] = (slot - 1) & mask_;
    }
    const std::size_t known = first_new + missing - points_.size();
    many_known_ = 8 * known > missing;
    if (known > 0) correct(missing, first_new, {triangles->data(), corners});
    return true;
}

/// Corrects the numbers of missing corners that turned out to be known points.
void FacetWelder::correct(std::uint32_t missing, std::uint32_t first_new, std::span<std::uint32_t> numbers)
{
    found_[missing] = 0;
    for (std::uint32_t& number : numbers) { // without branches, which would be mispredicted
        const std::uint32_t place = number - first_new, is_new = place < missing;
        number = number * (1 - is_new) + found_[std::min(place, missing)] * is_new;
    }
    for (std::size_t i = 0; i < missing; ++i) {
        const Corner& corner = corners_[missing_[i]];
        for (Recent& recent : recent_[corner.hash >> recent_shift_].entries)
            if (recent.key == corner.key) recent.number = found_[i];
    }
}

} // namespace oncollide
