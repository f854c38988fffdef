#pragma once
#include <span>
#include <vector>

#include <oncollide/base/aabb.hpp>
#include <oncollide/base/error.hpp>
#include <oncollide/pipeline/bodies.hpp>
#include <oncollide/pipeline/pairs.hpp>
#include <oncollide/pipeline/results.hpp>

namespace oncollide {

struct WorldImpl;

/// Queries of one thing against all bodies, as the World is now. World::space() returns them. They can be copied freely
/// and are valid as long as the World. step() gives the same results for a body of that geometry and pose, except that
/// segments are exact. Cost: proportional to the bodies that boxes cannot rule out. For contacts and penetration, pass
/// a hit's body to the queries of Pairs.
///
/// One name serves one thing and many, as in Pairs: with many things a query writes the results to its last argument,
/// on up to Settings::threads threads.
class ONCOLLIDE_API Space {
public:
    /// Bodies that a model at a pose may meet, sorted by slots.
    std::vector<QueryHit> overlaps(const PlacedModel& model, const CollisionFilter& filter = {}) const;
    void overlaps(std::span<const PlacedModel> models, const CollisionFilter& filter, Lists<QueryHit>& hits) const;
    /// Bodies that a segment touches, sorted by slots. For meshes, terrains, maps, boxes and hulls the results are
    /// exact with all settings, for the segment's points moved into the body's frame in double. Round shapes,
    /// half-spaces, a clearance, contact_kinds and ignore_touching have the errors of step(). Cost: 1 to 10
    /// microseconds for each body whose AABB the segment meets.
    std::vector<QueryHit> overlaps(const Segment& segment, const CollisionFilter& filter = {}) const;
    void overlaps(std::span<const Segment> segments, const CollisionFilter& filter, Lists<QueryHit>& hits) const;
    /// Bodies that a solid box of the world touches or contains, sorted by slots.
    std::vector<QueryHit> overlaps(const Aabb& box, const CollisionFilter& filter = {}) const;
    void overlaps(std::span<const Aabb> boxes, const CollisionFilter& filter, Lists<QueryHit>& hits) const;

    /// The first body that a segment hits, and where; its id is null if it hits none. A body is hit where overlaps() of
    /// the segment finds it with exact results; clearance, contact_kinds and ignore_touching have no effect. Where
    /// several bodies may be first, their smallest slot is returned, and then the smallest part; certain hits come
    /// before others. The bounds of the fraction then enclose the first point in any of these bodies. Cost: like the
    /// cost of overlaps() for the bodies in front of the hit; 3 to 20 microseconds for a round shape. Throws
    /// Error{bad_data} for a segment without length, not finite or beyond 1e15 m.
    CastHit cast(const Segment& segment, const CollisionFilter& filter = {}) const;
    void cast(std::span<const Segment> segments, const CollisionFilter& filter, std::span<CastHit> hits) const;
    /// The first contact of a moving model with the bodies at their poses. Without contact the body is null and the
    /// verdict `separate`. clear_until is certified for all bodies: for a planner, the last valid time of an edge. If a
    /// pair stays undecided before the first certain contact, its verdict and its body are returned.
    SweepHit cast(const MovingModel& model, const CollisionFilter& filter = {}, const SweepOptions& options = {}) const;
    void cast(std::span<const MovingModel> models, const CollisionFilter& filter, const SweepOptions& options,
              std::span<SweepHit> hits) const;
    /// The first point in each body that the segment hits, sorted by lower bounds of the fractions, then by slots.
    std::vector<CastHit> cast_all(const Segment& segment, const CollisionFilter& filter = {}) const;
    void cast_all(std::span<const Segment> segments, const CollisionFilter& filter, Lists<CastHit>& hits) const;
    /// The first contact with each body, sorted by clear_until, then by slots.
    std::vector<SweepHit> cast_all(const MovingModel& model, const CollisionFilter& filter = {},
                                   const SweepOptions& options = {}) const;
    void cast_all(std::span<const MovingModel> models, const CollisionFilter& filter, const SweepOptions& options,
                  Lists<SweepHit>& hits) const;

    /// Bodies at most `options.cutoff` (m, finite) away from a model at a pose, as Pairs::distance() measures them,
    /// sorted by slots.
    std::vector<BodyDistance> distances(const PlacedModel& model, const CollisionFilter& filter,
                                        const DistanceOptions& options) const;
    void distances(std::span<const PlacedModel> models, const CollisionFilter& filter, const DistanceOptions& options,
                   Lists<BodyDistance>& found) const;

private:
    friend class World;
    explicit Space(WorldImpl& world) : world_(&world) {}
    WorldImpl* world_;
};

} // namespace oncollide
