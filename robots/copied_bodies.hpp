#pragma once
#include <cstdint>
#include <vector>

#include <oncollide/pipeline/world/placed_tests.hpp>
#include <oncollide/robots/part_solids.hpp>
#include <oncollide/robots/robot.hpp>

namespace oncollide {

/// The bodies of WorldCopies, without regard to threads.
class CopiedBodies {
public:
    /// @param count  copies
    /// Throws Error{usage}.
    CopiedBodies(const World& world, const WorldCopies& copies, std::size_t count);

    std::size_t size() const { return slots_.size(); }
    std::uint32_t slot(std::size_t k) const { return slots_[k]; }
    /// The slots, sorted.
    const std::vector<std::uint32_t>& sorted() const { return sorted_; }
    /// Null if the slot is of no copied body.
    const Eigen::Isometry3d* pose_at(std::uint32_t slot, std::size_t copy) const;
    const Eigen::Isometry3d& pose(std::size_t k, std::size_t copy) const { return poses_[copy * size() + k]; }

private:
    std::span<const Eigen::Isometry3d> poses_;
    std::vector<std::uint32_t> slots_, sorted_, order_; ///< order_: the numbers of sorted_ in slots_
};

/// The same bodies in the copies of a chunk of configurations, for one thread.
class CopiedPlaces {
public:
    /// @param bodies  null: there are none
    void begin(const WorldAccess::PlacedTests& tests, const CopiedBodies* bodies, const CollisionFilter& filter);
    /// Places the bodies of the copies from `first` on. Throws Error{bad_data} for a pose that is not rigid.
    void place(std::size_t first, std::size_t count);
    bool is_empty() const { return kinds_.empty(); }
    /// Calls visit(k) for each body, of the filter's, whose box is at most `reach(box, size)` from the point. `size` is
    /// the sum of the coordinates of the box, relative to `origin`.
    template <class Reach, class Visit>
    void each_near(std::uint32_t copy, const Eigen::Vector3d& point, const Eigen::Vector3d& origin, Reach reach,
                   Visit visit) const;
    /// Body k in a copy of the chunk. Valid until the next call.
    const PlacedBody& body(std::uint32_t k, std::uint32_t copy);
    const Eigen::Isometry3d* pose_at(std::uint32_t slot, std::uint32_t copy) const
    {
        return bodies_ ? bodies_->pose_at(slot, first_ + copy) : nullptr;
    }

private:
    const CopiedBodies* bodies_ = nullptr;
    std::vector<PlacedBody> kinds_;        ///< the bodies that the filter allows
    std::vector<std::uint32_t> numbers_;   ///< of kinds_, in *bodies_
    std::vector<Eigen::Vector3d> middles_; ///< by copy, then as kinds_: the middles of the boxes in the world
    std::size_t first_ = 0;
};

template <class Reach, class Visit>
void CopiedPlaces::each_near(std::uint32_t copy, const Eigen::Vector3d& point, const Eigen::Vector3d& origin,
                             Reach reach, Visit visit) const
{
    for (std::uint32_t k = 0; k < kinds_.size(); ++k) {
        const PlacedBox& box = kinds_[k].box;
        const Eigen::Isometry3d& pose = bodies_->pose(numbers_[k], first_ + copy);
        const Eigen::Vector3d off = point - middles_[copy * kinds_.size() + k];
        const double far = reach(box, (origin - pose.translation()).cwiseAbs().sum() + box.centre.cwiseAbs().sum());
        const double most = far + box.half.norm() * (1 + 4e-6);
        if (off.squaredNorm() > most * most) continue;
        const Eigen::Vector3d beyond = ((pose.linear().transpose() * off).cwiseAbs() - box.half).cwiseMax(0);
        if (beyond.squaredNorm() <= far * far) visit(k);
    }
}

} // namespace oncollide
