#include <oncollide/narrowphase/pairs/depth_bounds.hpp>

#include <algorithm>
#include <vector>

#include <oncollide/narrowphase/pairs/containment.hpp>
#include <oncollide/narrowphase/pairs/depth/depth_steps.hpp>
#include <oncollide/narrowphase/pairs/pair_tests.hpp>
#include <oncollide/narrowphase/pairs/placed_pair.hpp>
#include <oncollide/scenes/model/map/map_access.hpp>

namespace oncollide {

namespace depth_bounds {

using Eigen::Isometry3d, Eigen::Vector3d;
constexpr std::size_t most_points = 256; ///< points of one body that are located in the other

/// Calls visit(point) for points of a body, in its own frame, that may be deep in the other.
/// @param box  a box around the other body, in this one's frame
void each_point(const Side& side, const Aabb& box, const Vector3d& towards, auto visit)
{
    const auto in_box = [&](const Vector3d& p) {
        return (p.array() >= box.min.array()).all() && (p.array() <= box.max.array()).all();
    };
    if (const Mesh* const mesh = side.model.surface_mesh()) {
        std::vector<bool> seen(mesh->vertices.size()); // vertices that no triangle uses are not points of the body
        for (const Triangle& triangle : mesh->triangles)
            for (const std::uint32_t v : triangle) {
                if (!seen[v] && in_box(mesh->vertices[v])) visit(mesh->vertices[v]);
                seen[v] = true;
            }
    } else if (const OccupancyMap* const map = side.model.map()) {
        MapAccess::each_cell(*map, box, [&](const MapCell& cell) {
            const Aabb of_cell = MapAccess::box(*map, cell);
            visit(of_cell.centre().cwiseMax(box.min.cwiseMin(of_cell.max)).cwiseMin(box.max.cwiseMax(of_cell.min)));
            return true;
        });
    }
    if (!side.model.is_bounded_shape()) return;
    const Convex& c = side.model.convex();
    visit(c.centre);
    if (side.model.kind() == Kind::polytope) return;
    const auto farthest = [&](const Vector3d& d) { visit(c.support(d) + c.radius / d.norm() * d * (1 - 0x1p-40)); };
    farthest(towards);
    for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {-1.0, 1.0}) farthest(sign * Vector3d::Unit(axis));
}

/// Raises found.depth to the depth of points of `inner` in `outer`.
/// @param towards  a direction in the world frame that points to `outer`
void find_deep(PairWorker& worker, const Side& inner, const Side& outer, bool of_a, const Vector3d& towards,
               Penetration& found)
{
    if (inner.model.kind() == Kind::terrain) return; // its surface would have too many points
    const Aabb box = outer.model.bounds().box(inner.pose.inverse(Eigen::Isometry) * outer.pose);
    // A terrain is solid below its surface.
    const Aabb wanted = outer.model.kind() == Kind::terrain ? bounds_of(inner.model.geometry()) : box;
    std::vector<Vector3d> points;
    each_point(inner, wanted, inner.pose.linear().transpose() * towards,
               [&](const Vector3d& p) { points.push_back(inner.pose * p); });
    // Points farther along `towards` are usually deeper.
    if (points.size() > most_points) {
        std::ranges::nth_element(points, points.begin() + most_points, std::ranges::greater{},
                                 [&](const Vector3d& p) { return towards.dot(p); });
        points.resize(most_points);
    }
    if (outer.model.is_bounded_shape()) {
        const Vector3d centre = outer.pose * outer.model.convex().centre;
        if (depth_in(worker, inner, centre) > 0) points.push_back(centre); // a point of both
    }
    const double off =
        0x1p-46 * (inner.pose.translation().norm() + inner.model.reach()) + stretch(inner.pose) * inner.model.reach();
    for (const Vector3d& p : points)
        if (const double depth = depth_in(worker, outer, p) - off; depth > found.depth)
            found.depth = depth, found.deepest = p, found.of_a = of_a;
}

} // namespace depth_bounds

Penetration depth_of_bounded(PairWorker& worker, const PairTask& task)
{
    using namespace depth_bounds;
    if (decides_b_first(task)) { // both orders have the same bounds
        Penetration found = depth_of_bounded(worker, task.swapped());
        found.of_a = !found.of_a, found.parting_along = -found.parting_along;
        return found;
    }
    const bool shapes = task.a->is_bounded_shape() && task.b->is_bounded_shape();
    Penetration found;
    const bool ground = task.a->kind() == Kind::terrain || task.b->kind() == Kind::terrain;
    const auto around = [](const Model& model) {
        return model.is_mesh() && model.closed() ? model.obb_tree() : nullptr;
    };
    if (!ground && tests_for(task).decide(worker, task, {}, nullptr).verdict == Verdict::separate &&
        !one_holds_the_other(task, worker.locator, around)) {
        if (shapes) found.parting_upper = 0;
        return found;
    }
    const Side a{*task.a, *task.pose_a}, b{*task.b, *task.pose_b};
    found.depth_upper = parting_translation(task);
    Vector3d towards = (b.pose * bounds_of(b.model.geometry()).centre()) -
                       (a.pose * bounds_of(a.model.geometry()).centre()); // from a to b
    if (shapes) {
        set_parting(task, found);
        found.depth_upper = std::min(found.depth_upper, found.parting_upper), towards = found.parting_along;
    }
    if (a.model.kind() == Kind::terrain) towards = a.pose.linear().col(2);
    if (b.model.kind() == Kind::terrain) towards = -b.pose.linear().col(2);
    for (const bool round_is_a : {true, false}) {
        const Side &round = round_is_a ? a : b, &other = round_is_a ? b : a;
        if (is_ball_or_capsule(round.model) && by_core(worker, round, other, round_is_a, found)) return found;
    }
    if (towards.isZero(0)) towards = Vector3d::UnitX();
    find_deep(worker, a, b, true, towards, found);
    find_deep(worker, b, a, false, -towards, found);
    found.depth = std::min(found.depth, found.depth_upper);
    return found;
}

} // namespace oncollide
