#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

constexpr double largest_coordinate = 1e15; ///< of a vertex or a height, metres

/// Throws Error{bad_data} that names the first vertex that is not finite or too far from the origin, as make_mesh.
/// @param first  number of the first vertex
void check_vertices(const std::string& name, std::span<const Eigen::Vector3d> vertices, std::size_t first = 0);

/// The result of a move of vertices.
struct VertexMove {
    double distance = 0; ///< upper bound of the distance that a vertex moved; 0: none did
    double radius2 = 0;  ///< squared distance of the farthest vertex that triangles use from the centre of the bounds
};

/// Gives the vertices of one mesh new positions. The triangles stay.
class VertexMover {
public:
    /// Cost: O(triangles).
    explicit VertexMover(const Mesh& mesh);

    /// Moves vertices [first, first + positions.size()) and renews the bounds. `zero_area` becomes the number of all
    /// triangles: their areas are not examined. The positions may be the mesh's own. Throws as
    /// check_vertices(); then nothing has changed. Cost: about two copies of the positions; for a part of the vertices
    /// also two passes over all of them.
    VertexMove move(const std::string& name, Mesh& mesh, std::size_t first,
                    std::span<const Eigen::Vector3d> positions) const;

private:
    void each_used(const Mesh& mesh, auto visit) const;

    std::vector<std::uint32_t> unused_; ///< vertices that no triangle uses: they are not part of the bounds
};

} // namespace oncollide
