#include <oncollide/narrowphase/solid.hpp>

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace oncollide {

double winding_number(const Mesh& mesh, const Eigen::Vector3d& point)
{
    double sum = 0;
    for (const Triangle& t : mesh.triangles) {
        const Eigen::Vector3d a = mesh.vertices[t[0]] - point, b = mesh.vertices[t[1]] - point,
                              c = mesh.vertices[t[2]] - point;
        const double la = a.norm(), lb = b.norm(), lc = c.norm();
        const double up = a.dot(b.cross(c));
        const double down = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        sum += std::atan2(up, down);
    }
    return sum / (2 * std::numbers::pi);
}

namespace {

/// A point of the geometry, in its own frame.
Eigen::Vector3d some_point(const Geometry& geometry)
{
    if (const auto* mesh = std::get_if<Mesh>(&geometry.data)) return mesh->vertices[mesh->triangles[0][0]];
    if (const auto* map = std::get_if<OccupancyMap>(&geometry.data)) return map->cells[0].centre();
    return bounds_of(geometry).centre();
}

bool holds(const Scene& scene, std::uint32_t outer, std::uint32_t inner)
{
    // Shapes are solid in every mode already: their trees and FCL's models have an inside.
    const auto* mesh = std::get_if<Mesh>(&scene.geometries[index(scene.geometry[outer])].data);
    if (!mesh) return false;
    const Geometry& other = scene.geometries[index(scene.geometry[inner])];
    const Eigen::Isometry3d to_outer = scene.poses[outer].inverse(Eigen::Isometry) * scene.poses[inner];
    const Eigen::Vector3d point = to_outer * some_point(other);
    if ((point.array() < mesh->bounds.min.array()).any() || (point.array() > mesh->bounds.max.array()).any()) return false;
    return std::abs(winding_number(*mesh, point)) > 0.5;
}

} // namespace

SolidTest::SolidTest(const Scene& scene)
{
    for (const Geometry& geometry : scene.geometries) {
        const auto* mesh = std::get_if<Mesh>(&geometry.data);
        solid_.push_back(mesh ? is_closed(*mesh) : std::holds_alternative<Shape>(geometry.data));
    }
}

bool SolidTest::encloses(const Scene& scene, std::uint32_t a, std::uint32_t b) const
{
    return (solid(scene.geometry[a]) && holds(scene, a, b)) || (solid(scene.geometry[b]) && holds(scene, b, a));
}

} // namespace oncollide
