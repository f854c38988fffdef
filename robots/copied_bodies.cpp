#include <oncollide/robots/copied_bodies.hpp>

#include <algorithm>
#include <numeric>

#include <fmt/format.h>

namespace oncollide {

CopiedBodies::CopiedBodies(const World& world, const WorldCopies& copies, std::size_t count) : poses_(copies.poses)
{
    const auto fail = [](const std::string& what) { throw Error(ErrorKind::usage, "robot: check: " + what); };
    if (poses_.size() != count * copies.bodies.size())
        fail(fmt::format("{} poses for {} copies of {} bodies", poses_.size(), count, copies.bodies.size()));
    for (std::size_t k = 0; k < copies.bodies.size(); ++k) {
        if (!world.bodies().contains(copies.bodies[k]))
            fail(fmt::format("body {} of the copies is not in the World", k));
        slots_.push_back(copies.bodies[k].slot);
    }
    order_.resize(slots_.size());
    std::iota(order_.begin(), order_.end(), 0u);
    std::ranges::sort(order_, {}, [&](std::uint32_t k) { return slots_[k]; });
    for (const std::uint32_t k : order_) sorted_.push_back(slots_[k]);
    if (std::ranges::adjacent_find(sorted_) != sorted_.end()) fail("a body of the copies is listed twice");
}

const Eigen::Isometry3d* CopiedBodies::pose_at(std::uint32_t slot, std::size_t copy) const
{
    const auto found = std::ranges::lower_bound(sorted_, slot);
    if (found == sorted_.end() || *found != slot) return nullptr;
    return &pose(order_[static_cast<std::size_t>(found - sorted_.begin())], copy);
}

void CopiedPlaces::begin(const WorldAccess::PlacedTests& tests, const CopiedBodies* bodies,
                         const CollisionFilter& filter)
{
    bodies_ = bodies, kinds_.clear(), numbers_.clear();
    for (std::uint32_t k = 0; bodies && k < bodies->size(); ++k) {
        const std::uint32_t slot = bodies->slot(k);
        if (!tests.allows(filter, slot)) continue;
        const Model& model = tests.model_at(slot);
        kinds_.emplace_back(slot, model.geometry(), model.bounds().box(Eigen::Isometry3d::Identity()),
                            Eigen::Isometry3d::Identity());
        numbers_.push_back(k);
    }
}

void CopiedPlaces::place(std::size_t first, std::size_t count)
{
    first_ = first, middles_.clear();
    if (!bodies_) return;
    for (std::size_t copy = first; copy < first + count; ++copy) {
        for (std::uint32_t k = 0; k < bodies_->size(); ++k)
            if (const std::string why = WorldAccess::why_refused(bodies_->pose(k, copy)); !why.empty())
                refuse(fmt::format("robot: check: copy {}: body {}", copy, k), why);
        for (std::size_t k = 0; k < kinds_.size(); ++k)
            middles_.push_back(bodies_->pose(numbers_[k], copy) * kinds_[k].box.centre);
    }
}

const PlacedBody& CopiedPlaces::body(std::uint32_t k, std::uint32_t copy)
{
    kinds_[k].box.pose = bodies_->pose(numbers_[k], first_ + copy);
    return kinds_[k];
}

} // namespace oncollide
