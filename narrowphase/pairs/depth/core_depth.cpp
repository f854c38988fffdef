#include <algorithm>

#include <oncollide/narrowphase/pairs/depth/depth_steps.hpp>
#include <oncollide/narrowphase/pairs/part_solid.hpp>
#include <oncollide/narrowphase/pairs/placed_pair.hpp>
#include <oncollide/narrowphase/shapes/convex_pair.hpp>
#include <oncollide/scenes/model/map/map_access.hpp>

namespace oncollide::depth_bounds {

using Eigen::Isometry3d, Eigen::Vector3d;
constexpr double core_share = 0x1p-20; ///< share of a radius that stays around a core to certify its distance

namespace {

/// The distance of a sphere's or a capsule's core, less core_share of the radius, from the other body's surface or
/// solid. World lengths.
Distance distance_of_core(PairWorker& worker, const Side& round, const Side& other)
{
    Convex core = round.model.convex();
    core.radius *= core_share;
    const PlacedPair placed(round.pose, other.pose);
    const Aabb box{core.low.array() - core.radius, core.high.array() + core.radius};
    const ShapeTree tree(core, box);
    const double error = other.model.kind() == Kind::terrain ? other.model.terrain()->error() : 0;
    const auto bounds = [&](double lower, double upper, const Vector3d& on_other) {
        return Distance{.lower = std::max(lower * (1 - placed.slack) - error, 0.0),
                        .upper = upper * (1 + placed.slack) + error,
                        .point_b = on_other};
    };
    const auto of = [&](auto& walk, auto& surface) {
        const auto d = walk.distance(tree, surface, placed.b_to_a, placed.slack, 0, infinity);
        const PartSolid part(surface, d.nearest->b);
        const ConvexDistance nearest = ConvexPair(core, part.solid(), placed.b_to_a, placed.slack).distance({});
        return bounds(d.lower, d.upper, round.pose * nearest.on_b);
    };
    switch (other.model.kind()) {
    case Kind::mesh: {
        ObbTree& surface = operand::Triangles::tree(other.model);
        return of(worker.solid_distance(surface), surface);
    }
    case Kind::terrain:
        return of(worker.solid_distance(other.model.heights()), other.model.heights());
    case Kind::map: {
        const PlacedPair back(other.pose, round.pose);
        MapShapeWalk& walk = worker.walk(other.model.cells(), tree);
        walk.leaves().prepare(back.slack, false);
        const auto d = walk.distance(other.model.cells(), tree, back.b_to_a, 0, infinity);
        if (!d.nearest) return bounds(0, infinity, Vector3d::Zero());
        const Convex cell = convex_of(MapAccess::box(*other.model.map(), d.nearest->a));
        const ConvexDistance nearest = ConvexPair(cell, core, back.b_to_a, back.slack).distance({});
        return bounds(d.lower, d.upper, other.pose * nearest.on_a);
    }
    default: {
        const ConvexDistance d = ConvexPair(core, other.model.convex(), placed.b_to_a, placed.slack).distance({});
        return bounds(d.lower, d.upper, round.pose * d.on_b);
    }
    }
}

/// True if the core of a sphere or a capsule, which does not meet the other body's surface, may be inside it. Over a
/// terrain the core must also be within the terrain's sides, because a way out through a side would not meet the
/// surface.
bool may_be_inside(PairWorker& worker, const Side& round, const Side& other)
{
    const Vector3d centre = round.pose.translation();
    if (other.model.kind() == Kind::mesh) {
        const Isometry3d here(Eigen::Translation3d{centre});
        return other.model.closed() &&
               worker.locator.place(Vector3d::Zero(), *other.model.mesh(), other.model.obb_tree(),
                                    RelativePose(here, other.pose)) != PointLocation::outside;
    }
    if (other.model.kind() != Kind::terrain) return false;
    const Terrain& terrain = *other.model.terrain();
    const Isometry3d into = other.pose.inverse(Eigen::Isometry);
    const Aabb box = round.model.bounds().box(into * round.pose), all = terrain.bounds();
    const bool within_sides = (box.min.head<2>().array() > all.min.head<2>().array()).all() &&
                              (box.max.head<2>().array() < all.max.head<2>().array()).all();
    return terrain.holes() || !within_sides || is_below(terrain, other.model.heights(), into * centre, 0);
}

} // namespace

bool is_ball_or_capsule(const Model& model)
{
    return model.kind() == Kind::round && model.convex().flat_sided;
}

bool by_core(PairWorker& worker, const Side& round, const Side& other, bool round_is_a, Penetration& found)
{
    const Convex& c = round.model.convex();
    const double size = (1 + rigid) * (c.radius + c.extent), radius = c.radius * (1 - core_share);
    const double apart = (round.pose.translation() - other.pose.translation()).norm();
    double rounding = 0x1p-44 * (size + apart) + 0x1p-48 * round.pose.translation().norm() + stretch(round.pose) * size;
    if (const Terrain* const terrain = other.model.terrain())
        rounding += 0x1p-38 * terrain->bounds().diagonal(); // is_below
    const Distance d = distance_of_core(worker, round, other);
    if (!(d.lower > rounding)) return false;
    const bool inside = may_be_inside(worker, round, other);
    // A point of the other body is this deep in the sphere.
    if (const double depth = radius - d.upper - rounding; depth > found.depth)
        found.depth = depth, found.of_a = !round_is_a, found.deepest = d.point_b;
    const double most =
        inside ? c.radius + (c.high - c.low).norm() + d.upper + c.radius * core_share : radius - d.lower;
    // Only a point below a terrain's surface, or in a closed mesh, is inside.
    found.depth_upper = std::min(found.depth_upper, std::max(most, 0.0) + rounding);
    return !inside;
}

} // namespace oncollide::depth_bounds
