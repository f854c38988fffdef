#include <oncollide/narrowphase/solid.hpp>

#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

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

/// One vertex of each part that shares no vertex with the others.
std::vector<Eigen::Vector3d> parts_of(const Mesh& mesh)
{
    std::vector<std::uint32_t> root(mesh.vertices.size());
    std::iota(root.begin(), root.end(), 0u);
    const auto find = [&](std::uint32_t v) {
        while (root[v] != v) v = root[v] = root[root[v]];
        return v;
    };
    for (const Triangle& t : mesh.triangles)
        for (int i : {1, 2}) root[find(t[i])] = find(t[0]);
    std::vector<Eigen::Vector3d> points;
    std::vector<std::uint8_t> seen(mesh.vertices.size());
    for (const Triangle& t : mesh.triangles)
        if (const std::uint32_t part = find(t[0]); !std::exchange(seen[part], 1)) points.push_back(mesh.vertices[part]);
    return points;
}

std::vector<Eigen::Vector3d> parts_of(const Geometry& geometry)
{
    if (const auto* mesh = std::get_if<Mesh>(&geometry.data)) return parts_of(*mesh);
    if (const auto* map = std::get_if<OccupancyMap>(&geometry.data)) return {map->cells[0].centre()};
    return {bounds_of(geometry).centre()};
}

} // namespace

SolidTest::SolidTest(const Scene& scene)
{
    for (const Geometry& geometry : scene.geometries) {
        const auto* mesh = std::get_if<Mesh>(&geometry.data);
        solid_.push_back(mesh ? is_closed(*mesh) : std::holds_alternative<Shape>(geometry.data));
        parts_.push_back(parts_of(geometry));
    }
}

bool SolidTest::holds(const Scene& scene, std::uint32_t outer, std::uint32_t inner) const
{
    // Shapes are solid in every mode already: their trees and FCL's models have an inside.
    const auto* mesh = std::get_if<Mesh>(&scene.geometries[index(scene.geometry[outer])].data);
    if (!mesh || !solid(scene.geometry[outer])) return false;
    const Eigen::Isometry3d to_outer = scene.poses[outer].inverse(Eigen::Isometry) * scene.poses[inner];
    for (const Eigen::Vector3d& part : parts_[index(scene.geometry[inner])]) {
        const Eigen::Vector3d point = to_outer * part;
        const bool in_box =
            (point.array() >= mesh->bounds.min.array()).all() && (point.array() <= mesh->bounds.max.array()).all();
        if (in_box && std::abs(winding_number(*mesh, point)) > 0.5) return true;
    }
    return false;
}

bool SolidTest::encloses(const Scene& scene, std::uint32_t a, std::uint32_t b) const
{
    return holds(scene, a, b) || holds(scene, b, a);
}

} // namespace oncollide
