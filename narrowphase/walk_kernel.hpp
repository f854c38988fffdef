// The walk of two trees, one implementation an instruction set. Plain data in, plain data out.
#pragma once
#include <cstdint>

#include <oncollide/narrowphase/cell_key.hpp>
#include <oncollide/narrowphase/ocst_node.hpp>
#include <oncollide/narrowphase/tight_block.hpp>

namespace oncollide {

constexpr int most_steps = 2 * deepest_level;

/// What one step down does. All pairs of cells at step s have the same two levels.
struct WalkStep {
    float scale_a, scale_b; ///< of the child offsets; 0: that side is not descended
    float size_a, size_b;   ///< of the cells that it leads to, the root being 1
    bool last_a, last_b;    ///< of those that descend that side: these cells are its leaves
    float reach2;           ///< squared distance up to which the children's spheres touch, widened for rounding
};

/// Two trees at one relative pose, everything in A's frame.
struct WalkPlan {
    alignas(32) float ax[8], ay[8], az[8]; ///< offsets of A's octants from their cell's centre at the root
    alignas(32) float bx[8], by[8], bz[8]; ///< of B's, turned into A's frame
    float d[3];                            ///< from A's root centre to B's
    int count;                             ///< steps
    WalkStep steps[most_steps];
    OcstNode *nodes_a, *nodes_b;
    std::uint32_t stamp; ///< this frame, shifted into place

    // Of tight cells alone:
    const TightBlock *tight_a, *tight_b; ///< by node, of its octants; null: plain spheres
    float turn[9];                       ///< from B's frame to A's, row-major
    float unit_a[4], unit_b[4];          ///< what a step of x, y, z and r is at the root, metres
    float reach;                         ///< distance up to which tight cells touch, widened for rounding
};

/// Two cells whose spheres touch, still to be opened.
struct WalkEntry {
    std::uint32_t a, b; ///< nodes; on a side that has reached its leaves, those that they are octants of
    float d[3];         ///< from a's centre to b's
    std::int32_t step;
    CellKey key_a, key_b;
    TightCell tight_a, tight_b; ///< of these cells, on a side that the next step does not descend
};

enum class WalkEnd : int { empty, hit, full, leaves };

/// Two leaf cells that touch, and the nodes that they are octants of.
struct LeafKeys {
    CellKey a, b;
    std::uint32_t parent_a, parent_b;
};

struct WalkState {
    WalkEntry* stack;
    std::uint32_t top;
    WalkEntry* parked; ///< out: entries that need a cell that is not expanded
    std::uint32_t parked_count, parked_room;
    CellKey hit_a, hit_b; ///< out
    LeafKeys* leaves;     ///< out: where pairs of leaves that touch go; null: the first one ends the walk
    std::uint32_t leaf_count, enough_leaves;
    std::uint64_t node_pairs;
    float nearest[most_steps]; ///< in and out, of the pairs cut at each step: smallest squared distance of their
                               ///< centres; of tight cells, smallest gap between them
};

/// A walk that gathers leaves ends when it has `enough_leaves`; room for 64 more is needed.
constexpr std::uint32_t first_leaves = 8, most_leaves = 256;

/// Entries that a walk may push above what it starts with.
constexpr std::uint32_t walk_stack_room = most_steps * 64 + 64;

struct WalkKernel {
    /// Depth first from the stack's entries until a pair of leaves touches (hit), enough of them are gathered (leaves),
    /// nothing is left (empty), or `parked` has no room (full). The stack holds the rest.
    WalkEnd (*walk)(const WalkPlan& plan, WalkState& state);
    /// True when the walk from the root to this pair of leaves meets every test: the same arithmetic, one path.
    bool (*replay)(const WalkPlan& plan, CellKey a, CellKey b);
};

namespace baseline {
WalkKernel walk_kernel();
}
namespace avx2 {
WalkKernel walk_kernel();
}
namespace avx512 {
WalkKernel walk_kernel();
}

} // namespace oncollide
