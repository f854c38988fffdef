// Meshes joined from meshes, and the winding number of a point.
#pragma once
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/scenes/model/mesh.hpp>

#include "verify/oracle/winding_number.hpp"

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

/// The mesh with reversed orientation.
inline Mesh flipped(Mesh mesh)
{
    for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
    return mesh;
}

inline double winding_number(const Mesh& mesh, const Eigen::Vector3d& point)
{
    return double(tools::winding_number(mesh.vertices, mesh.triangles, point));
}

} // namespace oncollide
