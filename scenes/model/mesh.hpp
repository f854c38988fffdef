#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <oncollide/base/aabb.hpp>

namespace oncollide {

/// Three vertex indices.
using Triangle = std::array<std::uint32_t, 3>;

/// A triangle mesh in its own frame, in the file's own coordinates times the unit scale (double, metres).
/// Made by make_mesh, so: at least one triangle, every index in range, every vertex finite.
struct Mesh {
    std::vector<Eigen::Vector3d> vertices;
    std::vector<Triangle> triangles;
    Aabb bounds;               ///< of the vertices that triangles use
    std::size_t zero_area = 0; ///< triangles without area: kept, they still collide
};

/// Checks and bounds a mesh. Unused vertices stay but do not count for the bounds.
/// @param name  names the mesh in errors: a path or a scene file's name
/// Throws Error{bad_data} naming the first offender: no triangle, index out of range, a vertex that is not finite or
/// whose magnitude exceeds 1e15 (the squared distances of the narrow phase must stay finite in float relative frames).
/// Cost: O(vertices + triangles).
Mesh make_mesh(const std::string& name, std::vector<Eigen::Vector3d> vertices, std::vector<Triangle> triangles);

/// Throws as make_mesh for a mesh that make_mesh did not make or that was changed since. Cost: as make_mesh.
void check_mesh(const std::string& name, const Mesh& mesh);

/// `mesh` with every vertex v replaced by scale * (v - origin). Throws Error{bad_data} if the result is not finite.
Mesh transformed(const std::string& name, Mesh mesh, double scale, const Eigen::Vector3d& origin);

/// True when every edge is shared by exactly two triangles that run along it in opposite directions (vertices at equal
/// positions count as one; zero-area triangles are left out): the mesh has an inside. Cost: O(n log n).
bool is_closed(const Mesh& mesh);

} // namespace oncollide
