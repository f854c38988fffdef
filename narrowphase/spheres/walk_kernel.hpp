// The traversal of two trees, one implementation per instruction set. Plain data in, plain data out.
#pragma once
#include <cstdint>

#include <oncollide/narrowphase/spheres/cell_key.hpp>
#include <oncollide/narrowphase/spheres/ocst_node.hpp>

namespace oncollide {

constexpr int most_steps = 2 * deepest_level;

/// One step down. All pairs of cells at step s have the same two levels.
struct WalkStep {
    float scale_a, scale_b; ///< scales of the child offsets; 0: that side is not descended
    float cutoff2;          ///< squared distance up to which the children's spheres touch, enlarged for rounding
};

/// Two trees at one relative pose; all data in A's frame.
struct WalkPlan {
    alignas(32) float ax[8], ay[8], az[8]; ///< offsets of A's octants from their cell's centre, at the root
    alignas(32) float bx[8], by[8], bz[8]; ///< B's, rotated into A's frame
    float d[3];                            ///< vector from A's root centre to B's
    int count;                             ///< steps
    WalkStep steps[most_steps];
    OcstNode *nodes_a, *nodes_b;
    std::uint32_t stamp; ///< this frame, shifted into position
};

/// Two cells whose spheres touch, still to be expanded.
struct WalkEntry {
    std::uint32_t a, b; ///< stored nodes; meaningless on a side that has reached its leaves
    float d[3];         ///< vector from a's centre to b's
    std::int32_t step;
    CellKey key_a, key_b;
};

enum class WalkEnd : int { empty, hit, full };

struct WalkState {
    WalkEntry* stack;
    std::uint32_t top;
    WalkEntry* parked; ///< out: entries that need an unexpanded cell
    std::uint32_t parked_count, parked_room;
    CellKey hit_a, hit_b; ///< out
    std::uint64_t node_pairs;
    float nearest2[most_steps]; ///< in and out: smallest squared distance of the pairs rejected at each step
};

/// Room for the entries that a traversal may push above its initial ones.
constexpr std::uint32_t walk_stack_room = most_steps * 64 + 64;

struct WalkKernel {
    /// Depth first from the stack's entries until a pair of leaves touches (hit), nothing is left (empty), or `parked`
    /// has no room (full: the stack holds the rest).
    WalkEnd (*walk)(const WalkPlan& plan, WalkState& state);
    /// True if the traversal from the root to this pair of leaves passes every test; uses the same arithmetic on one
    /// path.
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
