#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <oncollide/narrowphase/inside/mesh_links.hpp>
#include <oncollide/narrowphase/obb/obb_tree.hpp>

namespace oncollide {

/// A mesh with fewer triangles on the same surface, to the last bit: connected triangles in one plane are joined to
/// polygons, corners of these on straight edges are dropped, and the polygons are cut into triangles again.
struct FlatFaces {
    Mesh mesh;                         ///< has the corners that are left
    std::vector<std::uint32_t> vertex; ///< for each vertex: its number in the first mesh, the first one at its position
    std::vector<std::uint32_t> face;   ///< for each triangle: the first triangle of the first mesh in its polygon
};

/// None unless joining saves half of the triangles. Leaves polygons with corners at which they touch themselves as they
/// are. Deterministic. Cost: O(n log n), and quadratic in the corners of a polygon.
std::optional<FlatFaces> join_flat_faces(const Mesh& mesh, const MeshLinks& links);

/// The faces with their neighbours and their tree.
struct FlatSurface {
    FlatFaces faces;
    MeshLinks links;
    BoxTotals totals; ///< box totals of the tree
    ObbTree tree;

    explicit FlatSurface(FlatFaces joined)
        : faces(std::move(joined)), links(links_of(faces.mesh)), tree(faces.mesh, &totals)
    {
    }
};

} // namespace oncollide
