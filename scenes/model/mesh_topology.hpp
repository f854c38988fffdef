// How the triangles of a mesh hang together; is_closed() is in mesh.hpp. Vertices at equal positions count as one.
#pragma once
#include <cstdint>
#include <vector>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// An edge by its vertices' numbers in the mesh.
struct MeshEdge {
    std::uint32_t from, to;

    friend bool operator==(const MeshEdge&, const MeshEdge&) = default;
};

/// The edges that keep a mesh from being closed, each once: those that not exactly two triangles share, or that two run
/// along in the same direction. Triangles without area are left out. Cost: O(n log n).
std::vector<MeshEdge> open_edges(const Mesh& mesh);

/// Is every edge one of an even number of triangles? Then a point from which a ray crosses the surface an odd number of
/// times is enclosed: no way leads from it to the outside but through the surface. Cost: O(n log n).
bool edges_are_even(const Mesh& mesh);

/// By triangle: the number of its part, parts being numbered from 0 in the order of their first triangles. Triangles
/// that share a vertex are of one part. Cost: O(n log n).
std::vector<std::uint32_t> parts_of(const Mesh& mesh);

} // namespace oncollide
