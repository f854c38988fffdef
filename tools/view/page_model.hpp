#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include <oncollide/scenes/scene.hpp>

#include "view/page_blocks.hpp"

namespace oncollide::tools {

/// A geometry as a page shows it: coarser and coarser meshes, which only stand for it to the eye.
struct PageModel {
    /// Vertices are fractions of the box around the geometry: 0 its low side, 65535 its high side.
    struct Mesh {
        std::vector<std::array<std::uint16_t, 3>> vertices;
        std::vector<std::uint32_t> indices; ///< three a triangle

        std::size_t triangles() const { return indices.size() / 3; }
        /// Vertices, then indices: of 16 bits if they fit.
        PageBlock block() const;
    };
    std::string_view kind;       ///< mesh, shape, map or terrain
    Aabb box;                    ///< in its own frame, metres; a half-space's as far as it is shown
    std::uint64_t triangles = 0; ///< of the geometry itself; of a map its cells, of a shape none
    bool simplified = false;     ///< is the finest mesh coarser than the geometry?
    std::vector<Mesh> meshes;    ///< finest first
};

/// Triangles that its finest mesh has if nothing limits them.
std::uint64_t page_triangles(const Geometry& geometry);

/// @param most  triangles of the finest mesh, about
PageModel make_page_model(const Scene& scene, GeometryId geometry, std::uint64_t most);

} // namespace oncollide::tools
