#include <oncollide/scenes/columns.hpp>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <functional>

#include <oncollide/base/error.hpp>
#include <oncollide/base/function_ref.hpp>
#include <oncollide/base/memory/large_vector.hpp>

namespace oncollide {

namespace {

bool is_identity(const Eigen::Matrix3d& rotation)
{
    static const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
    return std::memcmp(rotation.data(), identity.data(), sizeof(double) * 9) == 0; // -0 is a different matrix
}

constexpr std::uint32_t no_body = 0xffffffffu;

std::uint32_t hash_of(std::string_view name)
{
    return static_cast<std::uint32_t>(std::hash<std::string_view>()(name));
}

/// Puts `slot` into the first free slot, starting at the position given by its hash.
template <class Slot>
void place(std::vector<Slot>& slots, const Slot& slot)
{
    const std::size_t mask = slots.size() - 1;
    std::size_t at = slot.hash & mask;
    while (slots[at].index != no_body) at = (at + 1) & mask;
    slots[at] = slot;
}

} // namespace

void NameColumn::push_back(std::string_view name)
{
    if (!name.empty()) {
        ends_.resize(size_, letters_.size());
        letters_ += name;
        append_large(ends_, letters_.size());
    }
    ++size_;
}

void PoseColumn::reserve(std::size_t bodies)
{
    reserve_large(positions_, bodies), reserve_large(rotated_, bodies);
    reserve_large(rotations_, bodies); // untouched pages take no memory
}

void PoseColumn::push_back(const Eigen::Isometry3d& pose)
{
    append_large(positions_, Eigen::Vector3d(pose.translation()));
    append_large(rotated_, 0u);
    set(size() - 1, pose);
}

void PoseColumn::set(std::size_t body, const Eigen::Isometry3d& pose)
{
    ONCOLLIDE_ASSERT(body < positions_.size() && rotated_[body] <= rotations_.size());
    positions_[body] = pose.translation();
    const Eigen::Matrix3d rotation = pose.linear();
    std::uint32_t& rotated = rotated_[body];
    if (rotated) {
        rotations_[rotated - 1] = rotation;
    } else if (!is_identity(rotation)) {
        append_large(rotations_, rotation);
        rotated = static_cast<std::uint32_t>(rotations_.size());
    }
}

const Motion& MotionColumn::operator[](std::size_t body) const
{
    static const Motion still = Still{};
    const auto found = std::ranges::lower_bound(bodies_, body);
    return found != bodies_.end() && *found == body ? motions_[std::size_t(found - bodies_.begin())] : still;
}

std::uint64_t ChangeLog::new_number()
{
    static std::atomic<std::uint64_t> last = 0;
    return ++last;
}

ChangeLog::ChangeLog(ChangeLog&& other) noexcept : ChangeLog()
{
    std::swap(log_, other.log_), std::swap(forgotten_, other.forgotten_), changes_.swap(other.changes_);
}

ChangeLog& ChangeLog::operator=(ChangeLog other) noexcept
{
    std::swap(log_, other.log_), std::swap(forgotten_, other.forgotten_), changes_.swap(other.changes_);
    return *this;
}

void ChangeLog::note(Change change, std::size_t most)
{
    if (changes_.size() >= most) { // keeps half, so that a reader that follows every step never falls behind
        const std::size_t half = changes_.size() / 2 + 1;
        changes_.erase(changes_.begin(), changes_.begin() + static_cast<std::ptrdiff_t>(half));
        forgotten_ += half;
    }
    changes_.push_back(change);
}

bool NameIndex::add(std::string_view name, std::uint32_t index, const NameOf& name_of)
{
    if (find(name, name_of)) return false;
    if (2 * (used_ + 1) > slots_.size()) grow();
    place(slots_, Slot{hash_of(name), index});
    ++used_;
    return true;
}

std::optional<std::uint32_t> NameIndex::find(std::string_view name, const NameOf& name_of) const
{
    if (slots_.empty()) return std::nullopt;
    const std::uint32_t hash = hash_of(name);
    const std::size_t mask = slots_.size() - 1;
    for (std::size_t at = hash & mask; slots_[at].index != no_body; at = (at + 1) & mask)
        if (slots_[at].hash == hash && name_of(slots_[at].index) == name) return slots_[at].index;
    return std::nullopt;
}

void NameIndex::grow()
{
    std::vector<Slot> larger(std::max<std::size_t>(16, 2 * slots_.size()), Slot{0, no_body});
    for (const Slot& slot : slots_)
        if (slot.index != no_body) place(larger, slot);
    slots_ = std::move(larger);
}

} // namespace oncollide
