// Connectivity of the triangles of a mesh; is_closed() is in mesh.hpp. Vertices at equal positions count as one.
#pragma once
#include <cstdint>
#include <vector>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// An edge, by the indices of its vertices in the mesh.
struct MeshEdge {
    std::uint32_t from, to;

    friend bool operator==(const MeshEdge&, const MeshEdge&) = default;
};

/// The edges that keep a mesh from being closed, each once: more triangles traverse such an edge in one direction than
/// in the other. Triangles without area are ignored. Cost: O(n log n).
std::vector<MeshEdge> open_edges(const Mesh& mesh);

/// True if every edge belongs to an even number of triangles. Then a point whose ray crosses the surface an odd number
/// of times is enclosed: every path from it to the outside crosses the surface. Cost: O(n log n).
bool edges_are_even(const Mesh& mesh);

/// Part number of each triangle; parts are numbered from 0 in the order of their first triangles. Triangles that share
/// a vertex belong to one part. Cost: O(n log n).
std::vector<std::uint32_t> parts_of(const Mesh& mesh);

/// For each vertex, by index: true if a triangle uses it.
std::vector<bool> used_vertices(const Mesh& mesh);

} // namespace oncollide
