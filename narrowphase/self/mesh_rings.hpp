#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// The edges of a mesh as a graph of its vertices.
class MeshRings {
public:
    /// @param vertex  for each vertex, the first one at its position; the others are not in the graph
    MeshRings(const Mesh& mesh, std::span<const std::uint32_t> vertex);

    /// Finds the vertices that at most a few edges connect to some vertices. Keeps its memory; one per thread.
    class Search {
    public:
        explicit Search(const MeshRings& rings) : rings_(rings) {}
        /// True if at most `edges` edges connect a vertex of `from` with one of `to`.
        bool connects(std::span<const std::uint32_t> from, std::span<const std::uint32_t> to, std::uint32_t edges);

    private:
        const MeshRings& rings_;
        std::vector<std::uint32_t> reached_;
    };

private:
    std::vector<std::uint32_t> begin_, beside_;
};

} // namespace oncollide
