#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <oncollide/base/aabb.hpp>
#include <oncollide/base/error.hpp>

namespace oncollide {

/// Three vertex indices.
using Triangle = std::array<std::uint32_t, 3>;

/// A triangle mesh in its own frame: the file's coordinates times the unit scale (double, metres). make_mesh guarantees
/// at least one triangle, that every index is in range, and that every vertex is finite.
struct Mesh {
    std::vector<Eigen::Vector3d> vertices;
    std::vector<Triangle> triangles;
    Aabb bounds;               ///< bounds of the vertices that triangles use
    std::size_t zero_area = 0; ///< triangles without area: kept, they still collide. If vertices were moved
                               ///< (Models::set_vertices), it is an upper bound
};

inline std::array<Eigen::Vector3d, 3> corners_of(const Mesh& mesh, std::uint32_t triangle)
{
    const auto& [a, b, c] = mesh.triangles[triangle];
    return {mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]};
}

/// Checks a mesh and computes its bounds. Unused vertices stay but are not part of the bounds.
/// @param name  names the mesh in errors: a path or a scene file's name
/// Throws Error{bad_data} naming the first fault: no triangle, an index out of range, a vertex that is not finite or
/// whose magnitude exceeds 1e15 (the squared distances of the narrow phase must stay finite in float relative frames).
/// Cost: O(vertices + triangles).
ONCOLLIDE_API Mesh make_mesh(const std::string& name, std::vector<Eigen::Vector3d> vertices,
                             std::vector<Triangle> triangles);

/// Throws as make_mesh, for a mesh that was made without make_mesh or changed since. Cost: as make_mesh.
ONCOLLIDE_API void check_mesh(const std::string& name, const Mesh& mesh);

/// `mesh` with every vertex v replaced by scale * (v - origin). Throws Error{bad_data} if the result is not finite.
ONCOLLIDE_API Mesh transformed(const std::string& name, Mesh mesh, double scale, const Eigen::Vector3d& origin);

/// True if as many triangles traverse each edge in one direction as in the other, so that the mesh has an inside: two
/// triangles, or four where the surfaces of two solids meet in an edge. Vertices at equal positions count as one;
/// zero-area triangles are ignored. Cost: O(n log n).
ONCOLLIDE_API bool is_closed(const Mesh& mesh);

} // namespace oncollide
