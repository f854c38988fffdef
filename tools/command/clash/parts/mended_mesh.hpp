#pragma once
#include <cstdint>
#include <string>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide::tools {

/// How a mesh was closed, and the edges that are still open.
struct Mending {
    std::size_t welded = 0;     ///< vertices that became one with another
    std::size_t split = 0;      ///< triangles that were divided at a vertex on their edge
    std::size_t turned = 0;     ///< triangles that now face the other way, as their neighbours do
    double moved = 0;           ///< no point of the surface moved by more
    std::size_t open_edges = 0; ///< edges that bound an odd number of triangles
    double open_length = 0;     ///< of these edges
    bool closed = false;

    bool changed() const { return welded || split || turned; }
    /// "36 vertices welded, 4 triangles split, 12 turned"; "" if nothing was done.
    std::string done() const;
    /// The reason why the mesh is open: "60 open edges"; "" for a closed one.
    std::string why_open() const;
};

struct MendedMesh {
    Mesh mesh;
    Mending mending;
};

/// Closes a mesh as a person sees it: vertices at most `distance` apart become one; a triangle with another's open
/// corner on its edge, within twice this, is divided there; triangles face the same side as their neighbours. Parts of
/// the surface that had to be turned have their outside outside. A closed mesh stays as it is, as does a mesh
/// that this does not close.
/// Cost: O(n log n); for k open edges up to k^2, but no more than 10^8 comparisons: after them the mesh stays open.
MendedMesh mended(const Mesh& mesh, double distance);

} // namespace oncollide::tools
