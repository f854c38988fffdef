#pragma once
#include <vector>

#include <oncollide/pipeline/world/placed_tests.hpp>
#include <oncollide/robots/clearances.hpp>
#include <oncollide/robots/edges/edge_motion.hpp>
#include <oncollide/robots/surroundings.hpp>

namespace oncollide {

/// Rules out pairs in whole windows of an edge, by solids around the parts. A point leaves the straight line between
/// its places at both ends of a window by at most BallTravel::sagitta(), so a plane that is farther than that from both
/// sides at both ends separates them in the whole window.
class EdgeCull {
public:
    EdgeCull(const Robot::Impl& robot, const World& world, const Clearances& clearances, EdgeMotion& motion);

    /// Forgets the directions of the last edge: findings must not depend on them.
    void start();
    /// False: the pair of an item is certainly apart in its window, in the middle of which motion.place() put the
    /// links.
    bool is_open(const EdgeItem& item, const EdgeWays& ways);
    /// The same for a part and a box, with a bound on the motion of the part.
    bool is_open(std::uint32_t part, std::uint32_t box, double begin, double end, double bent);

    /// Bodies that overlap the boxes; sorted by boxes.
    std::span<const AabbHit> around(std::span<const Aabb> boxes, const CollisionFilter& filter)
    {
        return tests_.around(boxes, filter);
    }
    /// For a pair that is apart by the World's settings: whether it is at most the clearance apart, as check() finds.
    bool within(const PairOfModels& pair, double clearance)
    {
        const PairTask task{0, &tests_.model(pair.a.model), &tests_.model(pair.b.model), &pair.a.pose, &pair.b.pose};
        return tests_.within(task, clearance).verdict == Verdict::within;
    }
    BodyId body_at(std::uint32_t slot) const { return tests_.body_at(slot); }
    /// The number of a body's box.
    std::uint32_t box_of(std::uint32_t slot) { return bodies_.number_of(slot); }
    const PlacedBox& box(std::uint32_t number) const { return bodies_[number].box; }
    double rounding() const { return rounding_; } ///< rounding of lengths, as a share: poses are not quite rigid

private:
    const Robot::Impl& robot_;
    const Clearances& clearances_;
    const double rounding_;
    EdgeMotion& motion_;
    WorldAccess::PlacedTests tests_;
    PlacedBodies bodies_;
    std::vector<Eigen::Vector3d> across_; ///< by pair of parts: the direction that was found last, seen from the link
};

} // namespace oncollide
