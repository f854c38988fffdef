// The search for overlapping boxes in an implicit 16-ary tree, one implementation an instruction set. Plain data.
#pragma once
#include <cstdint>

namespace oncollide {

/// One level of boxes, 16 and 16 together: a block of 96 floats, lo x of all 16, lo y, lo z, hi x, hi y, hi z. The last
/// block is padded with empty boxes. Block n is what node n of the level above holds, so a node is six lines of memory
/// one after the other.
struct BoxLevelView {
    const float* blocks;
    std::uint32_t count;         ///< boxes, padding not counted
    const std::uint16_t* moving; ///< by block: which of its boxes are or hold moving ones
    const std::uint32_t* layers; ///< by box, above level 0: of all bodies below, or-ed; null: they forbid nothing
    const std::uint32_t* masks;
};
constexpr std::uint32_t box_block = 96;

/// Levels from the boxes themselves (0) up to the first of at most 16.
struct BoxTreeView {
    static constexpr int most_levels = 8; ///< 16^8 boxes
    BoxLevelView level[most_levels];
    int levels;
};

/// Where found pairs (i[k], j[k]) of places go, as columns; `more` makes room for at least 32: it may take them away,
/// or move them.
struct PairSink {
    std::uint32_t *i, *j;
    std::uint64_t count, room;
    void (*more)(PairSink& sink);
    void* owner;
};

/// Overlapping pairs of boxes, i < j, not both still, each once.
struct BoxTreeKernel {
    /// Of level `stop`, over the whole tree.
    void (*all)(const BoxTreeView& tree, int stop, PairSink& sink);
    /// Of level 0, both below node `node` of level `level` (>= 1).
    void (*within)(const BoxTreeView& tree, int level, std::uint32_t node, PairSink& sink);
    /// Of level 0, one below node `a` and one below node `b` of level `level`; level 0: the two themselves.
    void (*between)(const BoxTreeView& tree, int level, std::uint32_t a, std::uint32_t b, PairSink& sink);
    /// Of `count` pairs (query, block): the boxes of the block that overlap boxes[6 * query] (lo x y z, hi x y z), as
    /// pairs (query, number in the level).
    void (*in_blocks)(const BoxLevelView& level, const std::uint32_t* queries, const std::uint32_t* blocks,
                      std::uint64_t count, const float* boxes, PairSink& sink);
    /// Boxes of level 0 that overlap `box` (lo x y z, hi x y z), as pairs (query, place).
    void (*below_root)(const BoxTreeView& tree, std::uint32_t query, const float box[6], PairSink& sink);
    /// The box around the 16 of a node: lo x y z, hi x y z.
    void (*bound)(const BoxLevelView& below, std::uint32_t node, float box[6]);
};

namespace baseline {
BoxTreeKernel box_tree_kernel();
}
namespace avx2 {
BoxTreeKernel box_tree_kernel();
}
namespace avx512 {
BoxTreeKernel box_tree_kernel();
}

} // namespace oncollide
