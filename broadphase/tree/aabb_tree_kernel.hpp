// The search for overlapping boxes in an implicit 16-ary tree, compiled once per instruction set. Plain data.
#pragma once
#include <cstdint>

#include <oncollide/broadphase/segment_line.hpp>

namespace oncollide {

/// One level of boxes in blocks of 16. A block is 96 floats: lo x of all 16 boxes, then lo y, lo z, hi x, hi y, hi z.
/// Empty boxes pad the last block. Block n holds the children of node n of the level above, in six consecutive cache
/// lines.
struct AabbLevelView {
    const float* blocks;
    std::uint32_t count;         ///< boxes, padding not counted
    const std::uint16_t* moving; ///< by block: which of its boxes are or hold moving bodies
    const std::uint32_t* layers; ///< by box, above level 0: bitwise or over all bodies below; null: no layer forbids a
                                 ///< pair
    const std::uint32_t* masks;
    const std::uint32_t* groups; ///< by box, above level 0: the group of all bodies below, 0 if there are none; null:
                                 ///< no group forbids a pair
};
constexpr std::uint32_t aabb_block = 96;
/// Stands in place of a group for bodies of several groups, or of none.
constexpr std::uint32_t mixed_groups = 0xffffffffu;

/// Levels from the boxes themselves (0) up to the first with at most 16 nodes.
struct AabbTreeView {
    static constexpr int most_levels = 8; ///< 16^8 boxes
    AabbLevelView level[most_levels];
    int levels;
};

/// Destination of found pairs of slots (i[k], j[k]), as columns. `more` makes room for at least 32 pairs: it may
/// consume the pairs or move the columns.
struct PairSink {
    std::uint32_t *i, *j;
    std::uint64_t count, room;
    void (*more)(PairSink& sink);
    void* owner;
};

/// Finds overlapping pairs of boxes, each pair once with i < j, at least one of the two moving.
struct AabbTreeKernel {
    /// Pairs of level `stop` in the whole tree.
    void (*all)(const AabbTreeView& tree, int stop, PairSink& sink);
    /// Pairs of level 0 with both boxes below node `node` of level `level` >= 1.
    void (*within)(const AabbTreeView& tree, int level, std::uint32_t node, PairSink& sink);
    /// Pairs of level 0 with one box below node `a` and one below node `b` of level `level`; level 0: the boxes a and b
    /// themselves.
    void (*between)(const AabbTreeView& tree, int level, std::uint32_t a, std::uint32_t b, PairSink& sink);
    /// For `count` pairs (query, block): the boxes of the block that overlap boxes[6 * query] (lo x y z, hi x y z), as
    /// pairs (query, index in the level).
    void (*in_blocks)(const AabbLevelView& level, const std::uint32_t* queries, const std::uint32_t* blocks,
                      std::uint64_t count, const float* boxes, PairSink& sink);
    /// Boxes of level 0 that overlap `box` (lo x y z, hi x y z), as pairs (query, slot).
    void (*below_root)(const AabbTreeView& tree, std::uint32_t query, const float box[6], PairSink& sink);
    /// Boxes of level 0 that a segment may meet, as pairs (query, slot).
    void (*on_segment)(const AabbTreeView& tree, std::uint32_t query, const SegmentLine& segment, PairSink& sink);
    /// The bounds of the 16 children of a node: lo x y z, hi x y z.
    void (*bound)(const AabbLevelView& below, std::uint32_t node, float box[6]);
};

namespace baseline {
AabbTreeKernel aabb_tree_kernel();
}
namespace avx2 {
AabbTreeKernel aabb_tree_kernel();
}
namespace avx512 {
AabbTreeKernel aabb_tree_kernel();
}

} // namespace oncollide
