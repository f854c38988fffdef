// Tests of many models at poses: for layers above that make the poses themselves.
#pragma once
#include <memory>
#include <span>

#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/narrowphase/model.hpp>
#include <oncollide/narrowphase/pairs/pair_task.hpp>
#include <oncollide/pipeline/world/world_access.hpp>

namespace oncollide {

/// Queries and decisions of a World without checks of poses, which must be rigid. The working memory stays from call to
/// call. Calls belong to one thread, while nothing changes the World.
class WorldAccess::PlacedTests {
public:
    explicit PlacedTests(const World& world);
    ~PlacedTests();

    bool are_of(const World& world) const;
    /// Takes in all changes of the World since the last call.
    void begin();

    /// Throws as a query with this model.
    Model& model(ModelId id) const;

    /// Bodies that the filter allows and whose AABBs are at most the clearance from each box; sorted by boxes, then by
    /// slots. Valid until the next call.
    std::span<const AabbHit> around(std::span<const Aabb> boxes, const CollisionFilter& filter);
    bool allows(const CollisionFilter& filter, std::uint32_t slot) const;
    Model& model_at(std::uint32_t slot) const;
    const Eigen::Isometry3d& pose_at(std::uint32_t slot) const;
    BodyId body_at(std::uint32_t slot) const;

    /// The results of Pairs::decide(), in the order of `tasks`. A World with an automatic exact level and `max_error`
    /// decides exactly where OBB trees refine: to find that two bodies meet takes less time than to bound their
    /// distance. Valid until the next call.
    std::span<const Finding> decide(std::span<const PairTask> tasks);
    /// For a pair that is apart by the World's settings: whether it is at most a clearance apart.
    Finding within(const PairTask& task, double clearance);
    /// As Pairs::distance().
    Distance distance(const PairTask& task, const DistanceOptions& options);
    /// As Pairs::manifold(). Valid until the next call.
    const Manifold& manifold(const PairTask& task, const ManifoldOptions& options);
    /// True if decide() decides by exact predicates. A verdict that is certain by other means is then the same verdict.
    bool is_exact() const;

private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

} // namespace oncollide
