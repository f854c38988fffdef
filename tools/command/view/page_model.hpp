#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include <oncollide/scenes/scene.hpp>

#include "view/page_blocks.hpp"

namespace oncollide::tools {

/// A geometry as a page shows it: meshes of decreasing detail, for display only.
struct PageModel {
    /// Vertices are fractions of the geometry's AABB: 0 is its low side, 65535 its high side.
    struct Mesh {
        std::vector<std::array<std::uint16_t, 3>> vertices;
        std::vector<std::uint32_t> indices; ///< three per triangle

        std::size_t triangles() const { return indices.size() / 3; }
        /// Vertices, then indices; indices have 16 bits if they fit.
        PageBlock block() const;
    };
    std::string_view kind;       ///< mesh, shape, map or terrain
    Aabb box;                    ///< in its own frame, metres; for a half-space as far as it is shown
    std::uint64_t triangles = 0; ///< triangles of the geometry itself; for a map its cells, for a shape 0
    bool simplified = false;     ///< the finest mesh is coarser than the geometry
    std::vector<Mesh> meshes;    ///< finest first
};

/// Triangles of its finest mesh if nothing limits them.
std::uint64_t page_triangles(const Geometry& geometry);

/// @param most  approximate limit on the triangles of the finest mesh
PageModel make_page_model(const Scene& scene, GeometryId geometry, std::uint64_t most);
/// The same for a mesh that deforms: only the finest mesh. @param source  set to the vertex of the geometry for each of
/// its vertices
PageModel make_page_model(const Scene& scene, GeometryId mesh, std::uint64_t most, std::vector<std::uint32_t>& source);
/// A vertex of PageModel::Mesh.
std::array<std::uint16_t, 3> fraction_of(const Aabb& box, const Eigen::Vector3d& point);

} // namespace oncollide::tools
