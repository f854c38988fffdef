#include "truth/truth.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <span>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/exact/relative_pose.hpp>

#include "truth/convex_truth.hpp"
#include "truth/exact_inside.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// A vertex of each part: of each set of triangles that are connected by vertices.
std::vector<std::uint32_t> part_vertices_of(const Mesh& mesh)
{
    std::vector<std::uint32_t> above(mesh.vertices.size());
    std::iota(above.begin(), above.end(), 0u);
    const auto root = [&](std::uint32_t v) {
        while (above[v] != v) v = above[v] = above[above[v]];
        return v;
    };
    for (const Triangle& t : mesh.triangles)
        for (std::uint32_t v : t) above[root(v)] = root(t[0]);
    std::vector<std::uint32_t> roots;
    for (const Triangle& t : mesh.triangles) roots.push_back(root(t[0]));
    std::ranges::sort(roots);
    roots.erase(std::unique(roots.begin(), roots.end()), roots.end());
    return roots;
}

bool is_half_space(const GeometryData& geometry)
{
    const auto* shape = std::get_if<Shape>(&geometry);
    return shape && std::holds_alternative<HalfSpace>(*shape);
}

bool is_round(const GeometryData& geometry)
{
    const auto* shape = std::get_if<Shape>(&geometry);
    return shape && !std::holds_alternative<Box>(*shape) && !std::holds_alternative<ConvexHull>(*shape) &&
           !std::holds_alternative<HalfSpace>(*shape);
}

Aabb widened(Aabb box, double by)
{
    box.min.array() -= by, box.max.array() += by;
    return box;
}

/// `box` in another frame.
Aabb in_frame(const Aabb& box, const Isometry3d& pose)
{
    Aabb result;
    for (const Vector3d& corner : corners_of(box)) result.add(pose * corner);
    return result;
}

/// True if one of 500 points in the intersection of both AABBs is inside both. The points fill even a thin
/// intersection.
bool share_a_point(const TruthModel& a, const BoxedTriangles& at_a, const TruthModel& b, const BoxedTriangles& at_b)
{
    constexpr int count = 500;
    const BoxedTriangles::Box both = at_a.box().intersection(at_b.box());
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> part;
    for (int k = 0; k < count; ++k) {
        const Vector3d at = k ? Vector3d(part(random), part(random), part(random)) : Vector3d::Constant(0.5);
        const Vector3d p = both.min() + (both.max() - both.min()).cwiseProduct(at);
        if (a.winds_around(at_a, p) && b.winds_around(at_b, p)) return true;
    }
    return false;
}

/// True if the intersection of both AABBs is thinner than the library searches.
bool narrow(const BoxedTriangles::Box& a, const BoxedTriangles::Box& b)
{
    const BoxedTriangles::Box all = a.merged(b);
    const Vector3d extent = a.intersection(b).sizes();
    const double far = std::max(all.min().cwiseAbs().maxCoeff(), all.max().cwiseAbs().maxCoeff());
    return extent.minCoeff() < std::max(0x1p-18 * extent.maxCoeff(), 0x1p-32 * far);
}

bool holds_a_part(const TruthModel& outer, const BoxedTriangles& there, const TruthModel& inner,
                  const BoxedTriangles& here)
{
    return outer.has_inside() && std::ranges::any_of(inner.part_vertices(), [&](std::uint32_t v) {
               return outer.winds_around(there, here.points()[v]);
           });
}

/// The mesh holds a shape, or a cell of a map.
bool holds_other(const TruthModel& outer, const Isometry3d& pose, const TruthModel& inner, const Isometry3d& inner_pose)
{
    if (!outer.is_surface() || !outer.has_inside() || inner.is_surface()) return false;
    const RelativePose into(pose, inner_pose);
    const auto inside = [&](const Vector3d& p) { return outer.winds_around(outer.at_home(), into(p)); };
    const GeometryData& geometry = inner.geometry();
    if (const auto* map = std::get_if<OccupancyMap>(&geometry)) {
        bool found = false;
        map->each_box([&](const Aabb& cell) { found = found || inside(cell.centre()); });
        return found;
    }
    const auto* hull = std::get_if<ConvexHull>(&std::get<Shape>(geometry));
    return inside(hull ? hull->points.front() : bounds_of(geometry).centre());
}

PairTruth truth_of_surfaces(const TruthModel& a, const Isometry3d& pose_a, const TruthModel& b,
                            const Isometry3d& pose_b, const TruthParts& parts)
{
    const BoxedTriangles& at_a = a.at_home();
    const BoxedTriangles at_b(b.halved(), RelativePose(pose_a, pose_b));
    PairTruth truth;
    truth.kinds = parts.kinds;
    truth.contact = contact_of(at_a, at_b, parts.kinds ? TriangleContact::crossing : TriangleContact::touching);
    truth.collide = truth.contact != TriangleContact::separate;
    truth.deep = truth.collide && parts.deep && cross_deeply(at_a, at_b);
    if (parts.kinds && truth.contact == TriangleContact::touching && a.has_inside() && b.has_inside() &&
        share_a_point(a, at_a, b, at_b))
        truth.contact = TriangleContact::crossing, truth.vague = narrow(at_a.box(), at_b.box());
    truth.enclosed = !truth.collide && (holds_a_part(a, at_a, b, at_b) || holds_a_part(b, at_b, a, at_a));
    return truth;
}

/// Tests parts near the other body first: a map may have millions.
TrueDistance bounded_distance(const TruthModel& a, const Isometry3d& pose_a, const TruthModel& b,
                              const Isometry3d& pose_b, double least)
{
    const auto sets = [](const TruthModel& model, const Isometry3d& pose, const TruthModel& other,
                         const Isometry3d& other_pose, double within) {
        const Aabb around = widened(in_frame(bounds_of(other.geometry()), pose.inverse() * other_pose), within);
        return convex_sets(model.geometry(), pose, &around);
    };
    double far = 0; // all parts are within this distance
    for (const auto& [model, pose] : {std::pair(&a, &pose_a), std::pair(&b, &pose_b)})
        far += 2 * (bounds_of(model->geometry()).diagonal() + pose->translation().norm() +
                    bounds_of(model->geometry()).centre().norm());
    for (double within = 0x1p-10 * far + least;; within *= 4) {
        const std::vector<ConvexSet> of_a = sets(a, pose_a, b, pose_b, within),
                                     of_b = sets(b, pose_b, a, pose_a, within);
        if (!of_a.empty() && !of_b.empty())
            if (const TrueDistance found = true_distance(of_a, of_b); found.upper <= 0.99 * within || within > far)
                return found;
    }
}

TrueDistance convex_distance(const TruthModel& a, const Isometry3d& pose_a, const TruthModel& b,
                             const Isometry3d& pose_b, double least)
{
    const bool plane_a = is_half_space(a.geometry()), plane_b = is_half_space(b.geometry());
    if (plane_a && plane_b) return half_spaces_distance(pose_a, pose_b);
    if (plane_a) return half_space_distance(pose_a, convex_sets(b.geometry(), pose_b));
    if (plane_b) return half_space_distance(pose_b, convex_sets(a.geometry(), pose_a));
    return bounded_distance(a, pose_a, b, pose_b, least);
}

double truth_size(const TruthModel& a, const TruthModel& b)
{
    double size = 0;
    for (const TruthModel* model : {&a, &b})
        if (!is_half_space(model->geometry())) size = std::max(size, bounds_of(model->geometry()).diagonal());
    return size;
}

/// Error of the distance of convex sets, and of the library's bounds between them, relative to their size.
constexpr double convex_rounding = 0x1p-44;

PairTruth truth_of_others(const TruthModel& a, const Isometry3d& pose_a, const TruthModel& b, const Isometry3d& pose_b,
                          const TruthParts& parts)
{
    PairTruth truth;
    truth.surfaces = truth.kinds = false;
    truth.distance.size = truth_size(a, b), truth.slack = convex_rounding * truth.distance.size;
    const auto distance = [&](const Vector3d& off) {
        return convex_distance(a, pose_a, b, Eigen::Translation3d(off) * pose_b, parts.within);
    };
    const TrueDistance found = distance(Vector3d::Zero());
    truth.distance.low = double(found.lower), truth.distance.high = double(found.upper);
    truth.collide = found.upper == 0;
    const bool round = is_round(a.geometry()) || is_round(b.geometry());
    if (truth.collide && (round || parts.deep)) {
        truth.deep = true; // if they still overlap when moved by more than rounding in any direction
        for (int axis = 0; axis < 3; ++axis)
            for (const double by : {-truth.slack, truth.slack})
                truth.deep = truth.deep && distance(by * Vector3d::Unit(axis)).upper == 0;
    }
    truth.collide = truth.collide && (!round || truth.deep);
    truth.open = !truth.collide && truth.distance.low <= truth.slack;
    truth.enclosed = !truth.collide && (holds_other(a, pose_a, b, pose_b) || holds_other(b, pose_b, a, pose_a));
    return truth;
}

} // namespace

TruthModel::TruthModel(const GeometryData& geometry, bool solid) : geometry_(&geometry)
{
    if (const auto* mesh = std::get_if<Mesh>(&geometry)) {
        prepare(*mesh, solid);
    } else if (const auto* terrain = std::get_if<Terrain>(&geometry)) {
        made_ = std::make_shared<const Mesh>(mesh_of(*terrain));
        prepare(*made_, solid);
    }
}

TruthModel::TruthModel(const Mesh& mesh, bool solid)
{
    prepare(mesh, solid);
}

void TruthModel::prepare(const Mesh& mesh, bool solid)
{
    halved_.emplace(mesh);
    at_home_.emplace(*halved_, [](const Vector3d& v) { return v; });
    if (!solid) return;
    closed_ = !made_ && tools::has_inside(mesh);
    part_vertices_ = part_vertices_of(mesh);
}

bool TruthModel::winds_around(const BoxedTriangles& here, const Vector3d& point) const
{
    if (!closed_ || !here.box().contains(point)) return false;
    const auto triangle = [&](std::size_t i) { return here.triangle(std::uint32_t(i)); };
    return oracle::winding(here.mesh().triangles.size(), triangle, point).value_or(0) != 0;
}

bool TruthModel::is_uncertain() const
{
    const auto* terrain = geometry_ ? std::get_if<Terrain>(geometry_) : nullptr;
    return terrain && terrain->error() > 0;
}

PairTruth truth_of(const TruthModel& a, const Isometry3d& pose_a, const TruthModel& b, const Isometry3d& pose_b,
                   const TruthParts& parts)
{
    PairTruth truth;
    if (a.is_surface() && b.is_surface()) {
        truth = truth_of_surfaces(a, pose_a, b, pose_b, parts);
        if (parts.distance) measure(truth, a, pose_a, b, pose_b);
    } else {
        truth = truth_of_others(a, pose_a, b, pose_b, parts);
    }
    truth.uncertain = a.is_uncertain() || b.is_uncertain();
    return truth;
}

void measure(PairTruth& truth, const TruthModel& a, const Isometry3d& pose_a, const TruthModel& b,
             const Isometry3d& pose_b)
{
    if (!truth.surfaces) return; // known
    truth.distance = surface_distance(a.halved(), pose_a, b.halved(), pose_b);
    truth.slack = 0x1p-50 * truth.distance.size;
    if (truth.collide) truth.distance.low = 0;
}

bool has_inside(const Mesh& mesh)
{
    using Place = std::array<double, 3>;
    std::map<std::pair<Place, Place>, int> edges;
    for (const Triangle& t : mesh.triangles) {
        const Vector3d &p = mesh.vertices[t[0]], &q = mesh.vertices[t[1]], &r = mesh.vertices[t[2]];
        if (collinear(p, q, r)) continue;
        for (const auto& [from, to] : {std::pair(&p, &q), std::pair(&q, &r), std::pair(&r, &p)})
            ++edges[{Place{from->x(), from->y(), from->z()}, Place{to->x(), to->y(), to->z()}}];
    }
    for (const auto& [edge, count] : edges) {
        const auto back = edges.find({edge.second, edge.first});
        if (back == edges.end() || back->second != count) return false;
    }
    return !edges.empty();
}

} // namespace oncollide::tools
