#pragma once
#include <cstdint>
#include <span>
#include <string_view>

#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/narrowphase/verdict.hpp>
#include <oncollide/scenes/ids.hpp>

namespace oncollide {

/// One candidate pair at the end of a frame.
struct PairResult {
    BodyId a, b; ///< in the order of their slots
    Verdict verdict;
    std::uint8_t stage; ///< index into World::stages() of the stage that decided
    ContactKind kind;   ///< touching and crossing: where Settings::contact_kinds or ignore_touching requests them
    double bound;       ///< separate: certified lower bound on the distance, perhaps an earlier frame's less what the
                        ///< bodies can have moved since; within, undecided: certified upper bound; colliding: 0
};

/// Two bodies.
struct PairOfBodies {
    BodyId a, b;
    friend bool operator==(const PairOfBodies&, const PairOfBodies&) = default;
};

/// Counts of one stage. Summed over frames by World::totals().
struct StageStats {
    std::string_view stage;
    std::string_view unit; ///< what is counted: "bodies" or "pairs"
    std::uint64_t frames = 0;
    std::uint64_t in = 0, out = 0, culled = 0, undecided = 0;
    double cpu_ms = 0;     ///< wall time, waiting included
    double gpu_ms = 0;     ///< time of the GPU's own clock
    double wait_ms = 0;    ///< part of cpu_ms in which the CPU did nothing but wait for the GPU
    bool skipped = false;  ///< left out, by request or because it could not pay for itself
    std::string_view note; ///< why it was skipped; empty otherwise
};

/// What refinement did in one frame.
struct TreeStats {
    std::uint64_t rounds = 0;         ///< batches given to the backend
    std::uint64_t rows = 0;           ///< cells expanded, all rounds
    std::uint64_t node_pairs = 0;     ///< pairs of cells, or of boxes, whose parts were compared
    std::uint64_t triangle_pairs = 0; ///< pairs of triangles tested by predicates
    std::uint64_t narrowed = 0;       ///< pairs of bodies narrowed down by boxes or exactly: each level counts
    std::uint64_t by_gap = 0;         ///< of these, apart since an earlier frame by a gap that was not used up
    std::uint64_t by_hull = 0;        ///< of these, apart by convex solids around their meshes
    std::uint64_t by_balls = 0;       ///< of these, meeting by balls within their meshes
    std::uint64_t by_witness = 0;     ///< of these, decided by what met last
    std::uint64_t unsure_pairs = 0;   ///< of these, left by the filter to exact arithmetic
    std::uint64_t nodes = 0;          ///< cells and boxes' nodes stored at the end of the frame, roots included
    std::uint64_t collapsed = 0;      ///< cells dropped by ageing or eviction
    std::uint64_t refused = 0;        ///< cells that a budget kept from being expanded
    std::uint64_t queries = 0;        ///< occlusion queries (gl-query)
    std::uint64_t gpu_bytes = 0;      ///< to the GPU and back
    std::uint64_t repeats = 0;        ///< batches done again with larger buffers
    std::size_t bytes = 0;            ///< nodes and triangle lists, float copies of the surfaces
};

/// One batch of cells given to the backend. Times are milliseconds since the frame began.
struct Round {
    double submitted_ms = 0; ///< handed over
    double waited_ms = 0;    ///< the CPU had no other walks left, and waited
    double done_ms = 0;      ///< finished, trees grown
    std::uint64_t rows = 0;  ///< cells
    double gpu_ms = 0;       ///< between the first and the last command of the batch, by the GPU's clock
    double wait_ms = 0;      ///< the CPU waited for it
    std::uint64_t bytes = 0; ///< to the GPU and back
};

/// The result of one frame. Valid until the next step.
struct FrameView {
    std::uint64_t frame; ///< counted from 0 by the World
    double ms;           ///< wall time of the frame, all stages
    /// Every pair that the broad phase kept, sorted by the slots of (a, b), separate ones included.
    std::span<const PairResult> pairs;
    std::span<const PairOfBodies>
        began; ///< pairs that are not separate, and were separate or no candidates before; sorted
    std::span<const PairOfBodies> ended; ///< the reverse; also where a body was removed, whose id is stale by then
    std::span<const StageStats> stages;  ///< of this frame, in order
    std::span<const DelimitationLevel> delimitation; ///< per level of the region hierarchy
    const TreeStats& trees;
    std::span<const Round> rounds; ///< in order
    std::uint64_t hash; ///< of the pairs of this frame that are not separate: slots, verdicts and bounds, and kinds
                        ///< where requested
};

} // namespace oncollide
