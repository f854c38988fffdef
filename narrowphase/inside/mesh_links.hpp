#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

struct FlatSurface;

/// How the triangles of a mesh are connected. Vertices at equal positions count as one.
struct MeshLinks {
    static constexpr std::uint32_t none = ~0u;
    std::vector<std::uint32_t> vertex; ///< for each vertex: the first one at its position
    std::vector<std::array<std::uint32_t, 3>>
        neighbours;                    ///< across the edge from corner k to the next; none: not just one
    std::vector<std::uint8_t> ridges;  ///< for each triangle: bit k if the edge from corner k to the next sticks out
    std::vector<bool> tips;            ///< for each vertex: an edge at its position sticks out
    bool closed = false;               ///< as is_closed()
    bool reversed = false;             ///< closed, and its triangles are clockwise seen from outside
    std::shared_ptr<FlatSurface> flat; ///< set by Model::links() for a mesh that has one; see flat_faces.hpp
};

/// Cost: O(n log n).
MeshLinks links_of(const Mesh& mesh);

} // namespace oncollide
