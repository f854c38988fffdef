#pragma once
#include <cstdint>
#include <vector>

#include <oncollide/narrowphase/obb/node_lines.hpp>

namespace oncollide {

/// The parts of an OBB tree that a copy with the first `from` lines of its nodes lacks (ObbTree::copy_growth).
struct TreeGrowth {
    std::uint32_t from = 0, lines = 0; ///< `added` holds the lines [from, lines)
    std::vector<NodeLine> added;
    std::vector<std::uint32_t> changed; ///< older lines in which child nodes were entered
    std::vector<NodeLine> contents;     ///< of these lines, in the same order
    struct Range {
        std::uint32_t begin, count;
    };
    std::vector<Range> sorted;        ///< parts of the tree's order that may have changed
    std::vector<std::uint32_t> order; ///< the triangles of these parts, by number in the mesh, one part after the other

    void clear() { added.clear(), changed.clear(), contents.clear(), sorted.clear(), order.clear(); }
};

} // namespace oncollide
