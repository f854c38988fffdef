#pragma once
#include <cstddef>
#include <cstdint>
#include <new>

#include <oncollide/narrowphase/obb/box_node.hpp>

namespace oncollide {

/// The nodes of a tree are stored consecutively in blocks of cache lines; a node's number is the number of its first
/// line. No node extends from one block into the next.
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

/// Upper bound of the lines of all nodes below a box of `triangles` triangles in a fully grown tree, with the unused
/// ends of blocks. A box of three or more triangles has eight children, or one for each of its triangles, or two or
/// three of at least six triangles. A node of single triangles takes three lines for at least three triangles, and a
/// node above eight of these five more: 29 lines for 24 triangles, and so on.
/// @param any  a box may have any number of children from two
constexpr std::uint64_t most_node_lines(std::uint64_t triangles, bool any)
{
    const std::uint64_t lines = any ? inner_node_lines * triangles : 26 * triangles / 21;
    return lines + (inner_node_lines - 1) * (lines / (lines_per_block - inner_node_lines + 1) + 1);
}

inline BoxNode& node_at(NodeLine* const* blocks, std::uint32_t number)
{
    return reinterpret_cast<BoxNode&>(blocks[number / lines_per_block][number % lines_per_block]);
}
/// The node must be `inner`.
inline InnerNode& inner_at(NodeLine* const* blocks, std::uint32_t number)
{
    return reinterpret_cast<InnerNode&>(node_at(blocks, number));
}
/// Makes an empty node of the requested size at that position.
inline BoxNode& make_node(NodeLine* const* blocks, std::uint32_t number, bool inner)
{
    NodeLine* const line = &blocks[number / lines_per_block][number % lines_per_block];
    BoxNode& node = inner ? (new (line) InnerNode{})->boxes : *new (line) BoxNode{};
    node.inner = inner;
    return node;
}

} // namespace oncollide
