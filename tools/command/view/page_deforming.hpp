#pragma once
#include <cstdint>
#include <vector>

#include <oncollide/scenes/scene.hpp>

#include "view/page_model.hpp"

namespace oncollide::tools {

/// The meshes of a page that deform: their triangles, and their vertices of each frame.
class DeformingModels {
public:
    /// Keeps a reference. Only meshes that bodies use take part.
    /// @param most  approximate limit on the triangles of all meshes together
    DeformingModels(const Scene& scene, std::uint64_t most);

    /// Null: the geometry is rigid, or no body uses it. Its vertices are of the first frame.
    const PageModel* of(std::uint32_t geometry) const;
    /// Columns of the current frame, mesh after mesh: AABBs (two corners each), and vertices as fractions of them.
    struct Columns {
        std::vector<double> boxes;
        std::vector<std::uint16_t> vertices;
    };
    Columns columns() const;
    std::size_t bytes_of_frame() const;

private:
    struct Shown {
        std::uint32_t geometry;
        PageModel model;
        std::vector<std::uint32_t> source; ///< by vertex of the model: the vertex of the geometry
    };
    const Scene& scene_;
    std::vector<Shown> shown_;
};

} // namespace oncollide::tools
