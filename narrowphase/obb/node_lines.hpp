#pragma once
#include <cstddef>
#include <cstdint>
#include <new>

#include <oncollide/narrowphase/obb/box_node.hpp>

namespace oncollide {

/// Nodes of a tree stand one after the other in blocks of cache lines; a node's number is that of its first line. None
/// goes from one block into the next.
struct alignas(64) NodeLine {
    std::byte bytes[64];
};

constexpr std::uint32_t lines_per_block = 256;
constexpr std::uint32_t box_node_lines = sizeof(BoxNode) / sizeof(NodeLine);
constexpr std::uint32_t inner_node_lines = sizeof(InnerNode) / sizeof(NodeLine);
constexpr std::uint32_t lines_of(bool inner)
{
    return inner ? inner_node_lines : box_node_lines;
}

/// Lines of the nodes below a box of so many triangles, at most, when all is grown, with what is left at the ends of
/// blocks. Each box of three or more has eight parts, or one for each of its triangles; a node of these takes three
/// lines for three triangles at least, and one above eight of them five more: 29 lines for 24 triangles, and so on.
/// @param any  parts may be any, two or more
constexpr std::uint64_t most_node_lines(std::uint64_t triangles, bool any)
{
    const std::uint64_t lines = any ? inner_node_lines * triangles : 26 * triangles / 21;
    return lines + (inner_node_lines - 1) * (lines / (lines_per_block - inner_node_lines + 1) + 1);
}

inline BoxNode& node_at(NodeLine* const* blocks, std::uint32_t number)
{
    return reinterpret_cast<BoxNode&>(blocks[number / lines_per_block][number % lines_per_block]);
}
/// Of a BoxNode that is `inner`.
inline InnerNode& inner_at(NodeLine* const* blocks, std::uint32_t number)
{
    return reinterpret_cast<InnerNode&>(node_at(blocks, number));
}
/// Makes an empty one there, of the size asked for.
inline BoxNode& make_node(NodeLine* const* blocks, std::uint32_t number, bool inner)
{
    NodeLine* const line = &blocks[number / lines_per_block][number % lines_per_block];
    BoxNode& node = inner ? (new (line) InnerNode{})->boxes : *new (line) BoxNode{};
    node.inner = inner;
    return node;
}

} // namespace oncollide
