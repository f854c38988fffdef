#include <oncollide/narrowphase/pairs/depth_bounds.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <oncollide/narrowphase/pairs/containment.hpp>
#include <oncollide/narrowphase/pairs/pair_tests.hpp>
#include <oncollide/narrowphase/pairs/part_solid.hpp>
#include <oncollide/narrowphase/pairs/placed_pair.hpp>
#include <oncollide/narrowphase/shapes/convex_pair.hpp>
#include <oncollide/scenes/model/box_corners.hpp>
#include <oncollide/scenes/model/map_access.hpp>

namespace oncollide {

namespace depth_bounds {

using Eigen::Isometry3d, Eigen::Vector3d;
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double rigid = 0x1p-18;        ///< as in walk_tests.hpp
constexpr double core_share = 0x1p-20;   ///< share of a radius that stays around a core to certify its distance
constexpr std::size_t most_points = 256; ///< of a body, located in the other

struct Side {
    Model& model;
    const Isometry3d& pose;
};

/// A lower bound on the distance of p, a point of the solid, from its surface; negative if p may be outside.
double depth_in(const Convex& c, const Vector3d& p)
{
    const double rounding = 0x1p-46 * (c.extent + c.radius + p.norm());
    const double across = std::hypot(p.x(), p.y());
    switch (c.core) {
    case Convex::Core::box: {
        const double inside = std::min((p - c.low).minCoeff(), (c.high - p).minCoeff());
        const double outside = (p - p.cwiseMax(c.low).cwiseMin(c.high)).norm();
        return c.radius + (outside > 0 ? -outside : inside) - rounding;
    }
    case Convex::Core::points: {
        double least = infinity;
        for (const Triangle& t : c.faces) {
            const Vector3d &q = c.points[t[0]], u = c.points[t[1]] - q, v = c.points[t[2]] - q, n = u.cross(v);
            const double length = n.norm();
            // The normal of a sliver errs by about the product's rounding over its length.
            const double off = rounding * (1 + u.norm() * v.norm() / length);
            if (length > 0) least = std::min(least, n.dot(q - p) / length - off);
        }
        return least < infinity ? least : -infinity;
    }
    case Convex::Core::cylinder:
        return std::min(c.high.x() - across, c.high.z() - std::abs(p.z())) - rounding;
    case Convex::Core::cone: {
        const double length = 2 * c.high.z(), slope = std::hypot(c.high.x(), length);
        const double side = (c.high.x() * (c.high.z() - p.z()) - length * across) / slope;
        return std::min(side, p.z() + c.high.z()) - rounding;
    }
    case Convex::Core::ellipsoid:
        return (1 - p.cwiseQuotient(c.high).norm()) * c.high.minCoeff() - rounding;
    }
    __builtin_unreachable();
}

/// A lower bound on the distance of a point from the triangles of a mesh or a terrain.
template <class Operand>
double distance_from_surface(PairWorker& worker, const Side& outer, const Vector3d& point)
{
    auto& tree = Operand::tree(outer.model);
    const Isometry3d here(Eigen::Translation3d{point});
    const double scale = bounds_of(outer.model.geometry()).diagonal() + (point - outer.pose.translation()).norm();
    const double radius = 0x1p-40 * scale; // of a ball instead of the point
    const Convex ball = convex_of(Shape(Sphere{radius}));
    const ShapeTree shape(ball, {Vector3d::Constant(-radius), Vector3d::Constant(radius)});
    const double slack = stretch(outer.pose);
    const auto found =
        worker.solid_distance(tree).distance(shape, tree, RelativePose(here, outer.pose), slack, 0, infinity);
    return found.lower * (1 - slack - rigid) - Operand::error(outer.model);
}

/// True if p, in the terrain's frame, is certainly below its surface.
bool is_below(const Terrain& terrain, TerrainTree& tree, const Vector3d& p, double margin)
{
    const double x = (p.x() - terrain.origin().x()) / terrain.spacing().x(),
                 y = (p.y() - terrain.origin().y()) / terrain.spacing().y();
    if (!(x >= 0 && y >= 0 && x < terrain.cells_x() && y < terrain.cells_y())) return false;
    const auto column = static_cast<std::uint32_t>(x), row = static_cast<std::uint32_t>(y);
    if (!terrain.has_cell(column, row)) return false;
    const std::uint32_t first = 2 * (row * terrain.cells_x() + column);
    for (std::uint32_t triangle : {first, first + 1}) {
        const auto [a, b, c] = tree.points(triangle);
        const Eigen::Vector2d u = (b - a).head<2>(), v = (c - a).head<2>(), w = (p - a).head<2>();
        const double area = u.x() * v.y() - u.y() * v.x();
        const double s = (w.x() * v.y() - w.y() * v.x()) / area, t = (u.x() * w.y() - u.y() * w.x()) / area;
        constexpr double off = 0x1p-40; // both triangles count at their common edge
        if (s < -off || t < -off || s + t > 1 + off) continue;
        const double height = a.z() + s * (b.z() - a.z()) + t * (c.z() - a.z());
        const double rounding = off * (std::abs(b.z() - a.z()) + std::abs(c.z() - a.z()));
        if (!(p.z() < height - rounding - margin)) return false;
    }
    return true;
}

/// A lower bound on the distance of a point (world frame) of the other body from the surface of this one; 0 or negative
/// if the point may be outside.
double depth_in(PairWorker& worker, const Side& outer, const Vector3d& point)
{
    const Vector3d p = outer.pose.inverse(Eigen::Isometry) * point;
    const double off = stretch(outer.pose) * p.norm() + 0x1p-46 * (p.norm() + outer.pose.translation().norm());
    switch (outer.model.kind()) {
    case Kind::mesh: {
        if (!outer.model.closed()) return 0;
        const Isometry3d here(Eigen::Translation3d{point});
        if (worker.locator.place(Vector3d::Zero(), *outer.model.mesh(), outer.model.obb_tree(),
                                 RelativePose(here, outer.pose)) != PointLocation::inside)
            return 0;
        return distance_from_surface<operand::Triangles>(worker, outer, point) - off;
    }
    case Kind::terrain:
        if (!is_below(*outer.model.terrain(), outer.model.heights(), p, off + outer.model.terrain()->error())) return 0;
        return distance_from_surface<operand::Heights>(worker, outer, point) - off;
    case Kind::map: {
        double most = 0;
        Aabb at;
        at.add(p);
        MapAccess::each_cell(*outer.model.map(), at, [&](const MapCell& cell) {
            most = std::max(most, depth_in(convex_of(MapAccess::box(*outer.model.map(), cell)), p));
            return true;
        });
        return most - off;
    }
    case Kind::polytope:
    case Kind::round:
        return depth_in(outer.model.convex(), p) - off;
    case Kind::half_space:
        break;
    }
    return 0;
}

/// Calls visit(point) for points of a body, in its own frame, that may be deep in the other.
/// @param box  around the other body, in this one's frame
void each_point(const Side& side, const Aabb& box, const Vector3d& towards, auto visit)
{
    const auto in_box = [&](const Vector3d& p) {
        return (p.array() >= box.min.array()).all() && (p.array() <= box.max.array()).all();
    };
    if (const Mesh* const mesh = side.model.surface_mesh()) {
        std::vector<bool> seen(mesh->vertices.size()); // vertices of no triangle are no points of the body
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
    if (side.model.kind() != Kind::polytope && side.model.kind() != Kind::round) return;
    const Convex& c = side.model.convex();
    visit(c.centre);
    if (side.model.kind() == Kind::polytope) return;
    const auto farthest = [&](const Vector3d& d) { visit(c.support(d) + c.radius / d.norm() * d * (1 - 0x1p-40)); };
    farthest(towards);
    for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {-1.0, 1.0}) farthest(sign * Vector3d::Unit(axis));
}

/// Raises found.depth to the depth of points of `inner` in `outer`.
/// @param towards  a direction in the world frame in which outer is
void find_deep(PairWorker& worker, const Side& inner, const Side& outer, bool of_a, const Vector3d& towards,
               Penetration& found)
{
    if (inner.model.kind() == Kind::terrain) return; // its surface has no end of points
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
    if (const Kind kind = outer.model.kind(); kind == Kind::polytope || kind == Kind::round) {
        const Vector3d centre = outer.pose * outer.model.convex().centre;
        if (depth_in(worker, inner, centre) > 0) points.push_back(centre); // a point of both
    }
    const double off =
        0x1p-46 * (inner.pose.translation().norm() + inner.model.reach()) + stretch(inner.pose) * inner.model.reach();
    for (const Vector3d& p : points)
        if (const double depth = depth_in(worker, outer, p) - off; depth > found.depth)
            found.depth = depth, found.deepest = p, found.of_a = of_a;
}

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

bool is_ball_or_capsule(const Model& model)
{
    return model.kind() == Kind::round && model.convex().flat_sided;
}

/// True if the core of a sphere or a capsule, which does not meet the other body's surface, may be inside it. Above a
/// terrain it must also be within the terrain's sides, through which a way out of it would not meet its surface.
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

/// If the core of a sphere or a capsule is outside the other body, the depth is the radius less their distance: a point
/// of the other body is that deep in the sphere, and no point of the sphere is deeper in the other body, because the
/// way to the core leaves it. If the core is inside, this bounds the depth.
/// @returns whether the depth is known
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

/// The shortest translation found that parts two convex solids: along directions from which a search descends.
std::pair<double, Vector3d> part_convex(const Side& a, const Side& b)
{
    const Convex &of_a = a.model.convex(), &of_b = b.model.convex();
    const PlacedPair placed(a.pose, b.pose);
    const Eigen::Matrix3d& turn = placed.b_to_a.rotation;
    const double size = of_a.extent + of_a.radius + of_b.extent + of_b.radius + placed.b_to_a.translation.norm();
    // b moves along n, in a's frame, beyond a.
    const auto width = [&](const Vector3d& n) {
        const double low_b = placed.b_to_a.translation.dot(n) - of_b.most_along(turn.transpose() * -n);
        return of_a.most_along(n) - low_b;
    };
    std::pair<double, Vector3d> best{infinity, Vector3d::UnitX()};
    const auto look = [&](const Vector3d& n) {
        const double w = width(n);
        if (w < best.first) best = {w, n};
        return best.second == n;
    };
    for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {-1.0, 1.0})
            look(sign * Vector3d::Unit(axis)), look(sign * turn.col(axis).normalized());
    if (const Vector3d middle = placed.b_to_a(of_b.centre) - of_a.centre; middle.norm() > 0) look(middle.normalized());
    for (double step = 0.5; step > 0x1p-16; step /= 2) {
        const Vector3d n = best.second, e = n.unitOrthogonal(), f = n.cross(e);
        for (const Vector3d& side : {e, f, Vector3d(-e), Vector3d(-f)}) look((n + step * side).normalized());
        if (best.second != n) step *= 2;
        if (best.first < 0x1p-50 * size) break;
    }
    const double upper = (std::max(best.first, 0.0) + 0x1p-46 * size) * (1 + 2 * placed.slack + 0x1p-40);
    return {upper, a.pose.linear() * best.second};
}

/// The highest point of a terrain's surface over a box of its frame; -infinity if there is none.
double highest_over(const Terrain& terrain, const Aabb& box)
{
    const Aabb& all = terrain.bounds();
    if ((box.max.head<2>().array() < all.min.head<2>().array()).any() ||
        (box.min.head<2>().array() > all.max.head<2>().array()).any())
        return -infinity;
    const auto column = [&](double x, int axis, std::uint32_t last) {
        const double at = std::floor((x - terrain.origin()[axis]) / terrain.spacing()[axis]);
        return static_cast<std::uint32_t>(std::clamp(at, 0.0, double(last)));
    };
    const std::uint32_t x0 = column(box.min.x(), 0, terrain.cells_x()), y0 = column(box.min.y(), 1, terrain.cells_y()),
                        x1 = std::min(column(box.max.x(), 0, terrain.cells_x()) + 1, terrain.cells_x()),
                        y1 = std::min(column(box.max.y(), 1, terrain.cells_y()) + 1, terrain.cells_y());
    constexpr std::uint64_t most_heights = 1 << 16;
    if (std::uint64_t{x1 - x0 + 1} * (y1 - y0 + 1) > most_heights) return terrain.bounds().max.z();
    double highest = -infinity;
    for (std::uint32_t y = y0; y <= y1; ++y)
        for (std::uint32_t x = x0; x <= x1; ++x)
            if (const double z = terrain.point(x, y).z(); z > highest) highest = z;
    return highest + terrain.error();
}

} // namespace depth_bounds

double parting_translation(const PairTask& task, std::span<const Eigen::Vector3d> normals)
{
    using namespace depth_bounds;
    const auto boxes_in = [&](const Isometry3d& frame) {
        const Isometry3d into = frame.inverse(Eigen::Isometry);
        return std::pair(task.a->bounds().box(into * *task.pose_a), task.b->bounds().box(into * *task.pose_b));
    };
    double least = infinity, size = 0;
    const auto along = [&](const Aabb& a, const Aabb& b, int axis, bool up_only, bool b_up) {
        size = std::max({size, a.diagonal(), b.diagonal(), a.min.cwiseAbs().maxCoeff(), b.max.cwiseAbs().maxCoeff()});
        if (!up_only || b_up) least = std::min(least, a.max[axis] - b.min[axis]);
        if (!up_only || !b_up) least = std::min(least, b.max[axis] - a.min[axis]);
    };
    const bool a_below = task.a->kind() == Kind::terrain, b_below = task.b->kind() == Kind::terrain;
    if (a_below || b_below) {
        auto [a, b] = boxes_in(a_below ? *task.pose_a : *task.pose_b);
        Aabb &ground = a_below ? a : b, &body = a_below ? b : a;
        const double slack = rigid * body.diagonal();
        const Aabb wide{body.min.array() - slack, body.max.array() + slack};
        ground.max.z() =
            std::min(ground.max.z(), highest_over(a_below ? *task.a->terrain() : *task.b->terrain(), wide));
        along(a, b, 2, true, a_below);
    } else {
        std::vector<Isometry3d> frames{*task.pose_a, *task.pose_b, Isometry3d::Identity()};
        for (const Vector3d& n : normals) frames.emplace_back(Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), n));
        for (const Isometry3d& frame : frames) {
            Isometry3d at = frame;
            at.translation() = task.pose_a->translation();
            const auto [a, b] = boxes_in(at);
            for (int axis = 0; axis < 3; ++axis) along(a, b, axis, false, false);
        }
    }
    if (!(least > -size)) return 0;
    const double slack = stretch(*task.pose_a) + stretch(*task.pose_b) + rigid;
    return std::max(least + slack * std::abs(least) + 0x1p-44 * size, 0.0);
}

Penetration depth_of_bounded(PairWorker& worker, const PairTask& task)
{
    using namespace depth_bounds;
    if (decides_b_first(task)) { // both orders have the same bounds
        Penetration found = depth_of_bounded(worker, task.swapped());
        found.of_a = !found.of_a;
        return found;
    }
    Penetration found;
    const bool ground = task.a->kind() == Kind::terrain || task.b->kind() == Kind::terrain;
    const auto around = [](const Model& model) {
        return model.is_mesh() && model.closed() ? model.obb_tree() : nullptr;
    };
    if (!ground && tests_for(task).decide(worker, task, {}, nullptr).verdict == Verdict::separate &&
        !one_holds_the_other(task, worker.locator, around))
        return found;
    const Side a{*task.a, *task.pose_a}, b{*task.b, *task.pose_b};
    found.depth_upper = parting_translation(task);
    Vector3d towards = (b.pose * bounds_of(b.model.geometry()).centre()) -
                       (a.pose * bounds_of(a.model.geometry()).centre()); // from a to b
    const auto convex = [](const Model& m) { return m.kind() == Kind::polytope || m.kind() == Kind::round; };
    if (convex(a.model) && convex(b.model)) {
        const auto [upper, direction] = part_convex(a, b);
        found.depth_upper = std::min(found.depth_upper, upper), towards = direction;
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
