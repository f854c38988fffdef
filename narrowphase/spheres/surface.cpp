#include <oncollide/narrowphase/spheres/surface.hpp>
#include <oncollide/scenes/model/map/map_access.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

namespace oncollide {

namespace {

float rounded_up(double x)
{
    return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity());
}

void put(Primitive& primitive, int point, const Eigen::Vector3d& p)
{
    for (int axis = 0; axis < 3; ++axis) primitive.point[point][axis] = static_cast<float>(p[axis]);
}

/// Unit normal of the float corners, so that it belongs to the triangle that the test uses; in double, so that thin
/// triangles keep a good one. Zero if the area is below 2^-26 of the longest edge squared: then only the edges decide.
Eigen::Vector3d normal_of(const Primitive& t)
{
    Eigen::Vector3d p[3];
    for (int i = 0; i < 3; ++i) p[i] = {t.point[i][0], t.point[i][1], t.point[i][2]};
    const Eigen::Vector3d e = p[1] - p[0], f = p[2] - p[0], n = e.cross(f);
    const double longest = std::max({e.squaredNorm(), f.squaredNorm(), (p[2] - p[1]).squaredNorm()});
    const double length = n.norm();
    return length > longest * 0x1p-26 ? Eigen::Vector3d(n / length) : Eigen::Vector3d::Zero();
}

void add_triangles(Surface& surface, const Mesh& mesh)
{
    surface.primitives.resize(mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        Primitive& primitive = surface.primitives[t];
        for (int i = 0; i < 3; ++i) put(primitive, i, mesh.vertices[mesh.triangles[t][i]] - surface.root.centre);
        const Eigen::Vector3d normal = normal_of(primitive);
        for (int i = 0; i < 3; ++i) primitive.point[i][3] = static_cast<float>(normal[i]);
    }
}

void add_boxes(Surface& surface, const OccupancyMap& map)
{
    surface.boxes = true;
    surface.primitives.reserve(map.count());
    MapAccess::each_cell(map, map.bounds(), [&](const MapCell& cube) {
        const Aabb cell = MapAccess::box(map, cube);
        Primitive& primitive = surface.primitives.emplace_back();
        put(primitive, 0, cell.min - surface.root.centre);
        put(primitive, 1, cell.max - surface.root.centre);
        put(primitive, 2, cell.max - surface.root.centre);
        for (auto& point : primitive.point) point[3] = 0;
        return true;
    });
}

void add_inside(Surface& surface, const Mesh& convex)
{
    for (const Triangle& t : convex.triangles) {
        const Eigen::Vector3d p = convex.vertices[t[0]] - surface.root.centre;
        const Eigen::Vector3d n =
            (convex.vertices[t[1]] - convex.vertices[t[0]]).cross(convex.vertices[t[2]] - convex.vertices[t[0]]);
        surface.inside.push_back({n.x(), n.y(), n.z(), n.dot(p)});
    }
}

} // namespace

RootCell root_cell_around(const Aabb& bounds)
{
    RootCell root;
    root.centre = bounds.centre();
    // The centre is rounded, so take the larger distance.
    const Eigen::Vector3d half = (bounds.max - root.centre).cwiseMax(root.centre - bounds.min);
    const double least = std::max(half.maxCoeff() / 64, 1e-12);
    root.radius = 0, root.scale = 0;
    for (int axis = 0; axis < 3; ++axis) {
        root.half[axis] = rounded_up(std::max(half[axis], least));
        root.radius += static_cast<double>(root.half[axis]) * root.half[axis];
        root.scale = std::max<double>(root.scale, root.half[axis]);
    }
    root.radius = std::sqrt(root.radius) * (1 + 1e-15);
    return root;
}

Surface mesh_surface(const Mesh& mesh, const RootCell& root)
{
    Surface surface;
    surface.root = root;
    add_triangles(surface, mesh);
    return surface;
}

Surface map_surface(const OccupancyMap& map, const RootCell& root)
{
    Surface surface;
    surface.root = root;
    add_boxes(surface, map);
    return surface;
}

Surface solid_surface(const Mesh& convex, const RootCell& root)
{
    Surface surface = mesh_surface(convex, root);
    add_inside(surface, convex);
    return surface;
}

} // namespace oncollide
