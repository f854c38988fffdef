#include <oncollide/narrowphase/pairs/manifolds/shapes/shape_measures.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/narrowphase/model.hpp>
#include <oncollide/narrowphase/pairs/manifolds/points/clip_polygon.hpp>
#include <oncollide/narrowphase/pairs/manifolds/points/point_hull.hpp>
#include <oncollide/scenes/model/box_corners.hpp>

namespace oncollide {

using Eigen::Vector3d;

namespace {

/// Points whose hull is the core, or nearly.
std::vector<Vector3d> extreme_points(const Convex& c)
{
    std::vector<Vector3d> points;
    const auto add_rim = [&](double z) {
        for (int k = 0; k < 16; ++k)
            points.emplace_back(c.high.x() * std::cos(k * M_PI / 8), c.high.x() * std::sin(k * M_PI / 8), z);
    };
    switch (c.core) {
    case Convex::Core::box:
        for (unsigned k = 0; k < 8; ++k) points.push_back(corner_of({c.low, c.high}, k));
        break;
    case Convex::Core::points:
        points.assign(c.points, c.points + c.count);
        break;
    case Convex::Core::cylinder:
        add_rim(-c.high.z()), add_rim(c.high.z());
        break;
    case Convex::Core::cone:
        add_rim(-c.high.z()), points.emplace_back(0, 0, c.high.z());
        break;
    case Convex::Core::ellipsoid:
        for (int x = -1; x <= 1; ++x)
            for (int y = -1; y <= 1; ++y)
                for (int z = -1; z <= 1; ++z)
                    if (x || y || z) points.push_back(c.support(Vector3d(x, y, z)));
        break;
    }
    return points;
}

bool holds_all(const Convex& outer, const Convex& inner, auto into_outer)
{
    const auto holds = [&](const Vector3d& p) { return outer.depth(into_outer(p)) >= inner.radius; };
    return holds(inner.centre) && std::ranges::all_of(extreme_points(inner), holds);
}

struct Plane {
    Vector3d normal, at; ///< outward
};
struct Faces {
    std::vector<Plane> planes;
    std::vector<std::vector<Vector3d>> polygons;
};

/// The faces of a polytope, or the plane of a half-space, which has no polygon.
Faces faces_of(const Model& model, auto place)
{
    Faces faces;
    if (model.kind() == Kind::half_space) {
        faces.planes.push_back({Vector3d::UnitZ(), Vector3d::Zero()}), faces.polygons.emplace_back();
        return faces;
    }
    ContactFace face;
    const auto take = [&] {
        std::vector<Vector3d> polygon;
        for (std::uint32_t i = 0; i < face.count; ++i) polygon.push_back(place(face.corner[i]));
        const Vector3d n = (place(face.corner[0] + face.normal) - polygon[0]).normalized();
        faces.planes.push_back({n, polygon[0]}), faces.polygons.push_back(std::move(polygon));
    };
    if (model.convex().core == Convex::Core::box) {
        for (int axis = 0; axis < 3; ++axis)
            for (const double sign : {-1.0, 1.0}) find_face(model, sign * Vector3d::Unit(axis), face), take();
        return faces;
    }
    for (const HullFaces::Face& f : model.hull_faces().faces()) {
        std::vector<Vector3d> polygon;
        for (const std::uint32_t v : model.hull_faces().corners(f)) polygon.push_back(place(model.convex().points[v]));
        const Vector3d n = (place(model.convex().points[model.hull_faces().corners(f)[0]] + f.normal) - polygon[0]);
        faces.planes.push_back({n.normalized(), polygon[0]}), faces.polygons.push_back(std::move(polygon));
    }
    return faces;
}

/// The area vector and the volume that the parts of one body's faces inside the other bound.
std::pair<Vector3d, double> part_inside(const Faces& own, const Faces& other, const Vector3d& origin, bool first)
{
    Vector3d area = Vector3d::Zero();
    double volume = 0;
    std::vector<Vector3d> scratch;
    for (std::size_t f = 0; f < own.polygons.size(); ++f) {
        std::vector<Vector3d> polygon = own.polygons[f];
        const auto same_face = [&](const Plane& plane) { // faces in one plane that look the same way bound both
            return plane.normal.dot(own.planes[f].normal) > 1 - 0x1p-40 &&
                   std::ranges::all_of(polygon, [&](const Vector3d& p) {
                       return std::abs(plane.normal.dot(p - plane.at)) <= 0x1p-40 * (1 + p.norm());
                   });
        };
        for (const Plane& plane : other.planes) {
            if (polygon.empty()) break;
            if (!same_face(plane))
                clip_behind(polygon, plane.normal, plane.at, scratch);
            else if (!first)
                polygon.clear();
        }
        for (std::size_t i = 2; i < polygon.size(); ++i) {
            const Vector3d s = 0.5 * (polygon[i - 1] - polygon[0]).cross(polygon[i] - polygon[0]);
            area += s, volume += s.dot(polygon[0] - origin) / 3;
        }
    }
    return {area, volume};
}

} // namespace

bool holds_other(const PairTask& task, const RelativePose& b_to_a)
{
    const auto back = [&](const Vector3d& p) -> Vector3d {
        return b_to_a.rotation.transpose() * (p - b_to_a.translation);
    };
    if (task.a->kind() == Kind::half_space) {
        const Convex& c = task.b->convex();
        return b_to_a(c.support(b_to_a.rotation.row(2).transpose())).z() + c.radius <= 0;
    }
    const Convex &a = task.a->convex(), &b = task.b->convex();
    return holds_all(a, b, b_to_a) || holds_all(b, a, back);
}

void measure_region(const PairTask& task, const RelativePose& b_to_a, std::span<const FewPoints::Candidate> points,
                    const Vector3d& normal, ManifoldRegion& region)
{
    Vector3d centre = Vector3d::Zero();
    for (const FewPoints::Candidate& c : points) centre += 0.5 / double(points.size()) * (c.on_a + c.on_b);
    region.centre = *task.pose_a * centre;
    region.area = region.volume = 0;
    if (task.b->kind() == Kind::round || task.a->kind() == Kind::round) return;
    // Faces that touch or are near have the area of the points' polygon.
    Vector3d area = Vector3d::Zero();
    for (std::size_t i = 2; i < points.size(); ++i)
        area += 0.5 * (points[i - 1].on_a - points[0].on_a).cross(points[i].on_a - points[0].on_a);
    region.area = std::abs(area.dot(normal));
    if (region.kind != RegionKind::crossing && region.kind != RegionKind::enclosed) return;
    const Faces a = faces_of(*task.a, [](const Vector3d&p) { return p; }), b = faces_of(*task.b, b_to_a);
    const Vector3d origin = task.a->kind() == Kind::half_space ? Vector3d(Vector3d::Zero()) : centre;
    const auto [area_a, volume_a] = part_inside(a, b, origin, true);
    const auto [area_b, volume_b] = part_inside(b, a, origin, false);
    region.volume = std::max(volume_a + volume_b, 0.0);
    region.area = std::abs((task.a->kind() == Kind::half_space ? area_b : area_a).dot(normal));
}

double lost_of_shapes(const PairTask& task, const RelativePose& b_to_a, std::span<const ManifoldPoint> points)
{
    const Eigen::Isometry3d relative = task.pose_a->inverse(Eigen::Isometry) * *task.pose_b;
    Aabb common = task.b->bounds().box(relative);
    if (task.a->kind() == Kind::half_space) {
        common.max.z() = std::min(common.max.z(), 0.0);
    } else {
        const Aabb box = task.a->bounds().box(Eigen::Isometry3d::Identity());
        common.min = common.min.cwiseMax(box.min), common.max = common.max.cwiseMin(box.max);
    }
    if ((common.min.array() > common.max.array()).any()) common.max = common.max.cwiseMax(common.min);
    const PointHull hull(points);
    double most = 0;
    for (unsigned k = 0; k < 8; ++k) most = std::max(most, hull.distance2(*task.pose_a * corner_of(common, k), most));
    return std::sqrt(most) + 0x1p-40 * (common.diagonal() + b_to_a.translation.norm());
}

} // namespace oncollide
