// Meshes made of meshes, and the number of times that they wind around a point, by solid angles.
#pragma once
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/scenes/mesh.hpp>

namespace oncollide {

inline Mesh joined(const std::vector<Mesh>& meshes)
{
    std::vector<Eigen::Vector3d> vertices;
    std::vector<Triangle> triangles;
    for (const Mesh& mesh : meshes) {
        const auto n = static_cast<std::uint32_t>(vertices.size());
        vertices.insert(vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
        for (const Triangle& t : mesh.triangles) triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
    }
    return make_mesh("joined", std::move(vertices), std::move(triangles));
}

inline Mesh moved(const Mesh& mesh, const Eigen::Vector3d& by)
{
    return transformed("moved", mesh, 1, -by);
}

/// Inside out.
inline Mesh flipped(Mesh mesh)
{
    for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
    return mesh;
}

/// 0 outside of a closed mesh, 1 inside; not on the surface.
/// Source: van Oosterom and Strackee, "The solid angle of a plane triangle", IEEE Trans. Biomed. Eng. 1983.
inline double winding_number(const Mesh& mesh, const Eigen::Vector3d& point)
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

} // namespace oncollide
