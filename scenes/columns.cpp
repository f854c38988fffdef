#include <oncollide/base/error.hpp>
#include <oncollide/scenes/scene.hpp>

#include <algorithm>
#include <atomic>
#include <cstring>

#include <oncollide/base/memory/large_vector.hpp>

namespace oncollide {

namespace {

bool is_identity(const Eigen::Matrix3d& rotation)
{
    static const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
    return std::memcmp(rotation.data(), identity.data(), sizeof(double) * 9) == 0; // -0 is a different matrix
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

} // namespace oncollide
