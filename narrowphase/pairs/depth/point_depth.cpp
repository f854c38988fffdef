#include <algorithm>
#include <cmath>

#include <oncollide/narrowphase/pairs/depth/depth_steps.hpp>
#include <oncollide/narrowphase/pairs/placed_pair.hpp>
#include <oncollide/scenes/model/map/map_access.hpp>

namespace oncollide::depth_bounds {

using Eigen::Isometry3d, Eigen::Vector3d;

namespace {

/// A lower bound on the distance of a point from the triangles of a mesh or a terrain.
template <class Operand>
double distance_from_surface(PairWorker& worker, const Side& outer, const Vector3d& point)
{
    auto& tree = Operand::tree(outer.model);
    const Isometry3d here(Eigen::Translation3d{point});
    const double scale = bounds_of(outer.model.geometry()).diagonal() + (point - outer.pose.translation()).norm();
    const double radius = 0x1p-40 * scale; // radius of the ball that replaces the point
    const Convex ball = convex_of(Shape(Sphere{radius}));
    const ShapeTree shape(ball, {Vector3d::Constant(-radius), Vector3d::Constant(radius)});
    const double slack = stretch(outer.pose);
    const auto found =
        worker.solid_distance(tree).distance(shape, tree, RelativePose(here, outer.pose), slack, 0, infinity);
    return found.lower * (1 - slack - rigid) - Operand::error(outer.model);
}

} // namespace

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
            most = std::max(most, convex_of(MapAccess::box(*outer.model.map(), cell)).depth(p));
            return true;
        });
        return most - off;
    }
    case Kind::polytope:
    case Kind::round:
        return outer.model.convex().depth(p) - off;
    case Kind::half_space:
        break;
    }
    return 0;
}

} // namespace oncollide::depth_bounds
