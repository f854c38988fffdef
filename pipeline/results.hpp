#pragma once
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include <oncollide/base/error.hpp>
#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/narrowphase/finding.hpp>
#include <oncollide/pipeline/settings.hpp>

namespace oncollide {

// The ids and the results that a World returns.

/// A body of a World, as Bodies::add() returned it. `BodyId{}` is null. The World refuses an id that is null, stale
/// (its body was removed) or foreign (another World issued it).
struct alignas(8) BodyId {
    std::uint32_t slot = 0;       ///< row in the World's columns; free slots are reused
    std::uint16_t generation = 0; ///< numbers the bodies that the slot has held, from 1; 0: null
    std::uint16_t world = 0;      ///< tag of the World that issued the id

    constexpr explicit operator bool() const { return generation != 0; }
    friend constexpr auto operator<=>(const BodyId&, const BodyId&) = default;
};

/// A model of a World, as Models::add() returned it; in the same form as BodyId.
struct alignas(8) ModelId {
    std::uint32_t slot = 0;
    std::uint16_t generation = 0;
    std::uint16_t world = 0;

    constexpr explicit operator bool() const { return generation != 0; }
    friend constexpr auto operator<=>(const ModelId&, const ModelId&) = default;
};

/// The slot of an id with this generation is not reused.
constexpr std::uint16_t last_generation = 0xffff;

constexpr std::uint32_t index(BodyId id)
{
    return id.slot;
}
constexpr std::uint32_t index(ModelId id)
{
    return id.slot;
}

// --- Frames.

/// One candidate pair at the end of a frame. The lower bound of a separate pair may come from an earlier frame: then
/// the motion of both bodies since that frame is subtracted.
struct PairResult : Finding {
    StageId stage = StageId::broad; ///< the stage that decided
    BodyId a, b;                    ///< a.slot < b.slot
};
static_assert(sizeof(PairResult) == 32);

/// When the two bodies of a pair first met in a frame in which one of them moved (Bodies::set_motion).
struct PairSweep : SweepResult {
    std::uint32_t pair = 0; ///< index in FrameView::pairs
};

/// Two sides of one kind, such as two bodies.
template <class Side>
struct PairOf {
    Side a, b;
    friend auto operator<=>(const PairOf&, const PairOf&) = default;
};
using PairOfBodies = PairOf<BodyId>;

/// Counts of one stage. WorldInfo::totals has the sums over all frames.
struct StageStats {
    std::string_view stage;
    std::string_view unit; ///< the unit of the counts: "bodies" or "pairs"
    std::uint64_t frames = 0;
    std::uint64_t in = 0, out = 0, culled = 0, undecided = 0;
    double cpu_ms = 0;     ///< wall time, waiting included
    double gpu_ms = 0;     ///< time of the GPU's own clock
    double wait_ms = 0;    ///< part of cpu_ms in which the CPU only waited for the GPU
    bool skipped = false;  ///< left out, by request or because it could not pay for itself
    std::string_view note; ///< why it was skipped; empty otherwise
};

/// Counts of the narrow phase in one frame.
struct TreeStats {
    std::uint64_t rounds = 0;         ///< batches given to the backend
    std::uint64_t rows = 0;           ///< cells expanded, all rounds
    std::uint64_t node_pairs = 0;     ///< pairs of cells, or of boxes, whose parts were compared
    std::uint64_t triangle_pairs = 0; ///< pairs of triangles tested by predicates
    std::uint64_t narrowed = 0;       ///< pairs of bodies that a level of the narrow phase tested; each level counts
    std::uint64_t kept = 0;           ///< pairs that keep their last result untested, because nothing about them
                                      ///< changed
    std::uint64_t by_gap = 0;         ///< narrowed pairs that are apart by a gap of an earlier frame that was not used
                                      ///< up
    std::uint64_t by_hull = 0;        ///< narrowed pairs that are apart by convex solids around their meshes
    std::uint64_t by_inner_spheres = 0; ///< narrowed pairs that meet by spheres inside their meshes,
                                        ///< or by a depth of an earlier frame that was not used up
    std::uint64_t by_witness = 0;       ///< narrowed pairs that were decided by the parts that met last
    std::uint64_t unsure_pairs = 0;     ///< pairs of triangles that the filter left to exact arithmetic
    std::uint64_t nodes = 0;            ///< cells and boxes' nodes stored at the end of the frame, roots included
    std::uint64_t collapsed = 0;        ///< cells dropped by ageing or eviction
    std::uint64_t refused = 0;          ///< cells that a budget kept from being expanded
    std::uint64_t queries = 0;          ///< occlusion queries (gl-query)
    std::uint64_t gpu_bytes = 0;        ///< bytes moved to the GPU and back
    std::uint64_t repeats = 0;          ///< batches done again with larger buffers
    std::size_t bytes = 0;              ///< nodes and triangle lists, float copies of the surfaces
};

/// One batch of cells given to the backend, or of pairs that the backend gl decides. Times are milliseconds since the
/// frame began.
struct Round {
    double submitted_ms = 0; ///< time at which the batch was handed over
    double waited_ms = 0;    ///< time at which the CPU had no other walks left, and waited
    double done_ms = 0;      ///< time at which the batch was finished and the trees had grown
    std::uint64_t rows = 0;  ///< cells, or pairs
    double gpu_ms = 0;       ///< between the first and the last command of the batch, by the GPU's clock
    double wait_ms = 0;      ///< the CPU waited for it
    std::uint64_t bytes = 0; ///< bytes moved to the GPU and back
};

/// The result of one frame. Valid until the next step.
struct FrameView {
    std::uint64_t frame; ///< counted from 0 by the World
    double ms;           ///< wall time of the frame, all stages
    /// Every pair that the broad phase kept, sorted by the slots of (a, b), separate ones included.
    std::span<const PairResult> pairs;
    std::span<const PairOfBodies>
        began; ///< pairs that are not separate, and were separate or no candidates before; sorted
    std::span<const PairOfBodies> ended; ///< pairs that were not separate, and are separate or no candidates now; also
                                         ///< of removed bodies, whose ids are stale by then
    std::span<const StageStats> stages;  ///< stages of this frame, in order
    std::span<const StageStats> totals;  ///< sums over all frames, in order
    std::span<const DelimitationLevel> delimitation; ///< per level of the region hierarchy
    const TreeStats& trees;
    std::span<const Round> rounds; ///< batches, in order
    std::uint64_t hash; ///< hash of the pairs of this frame that are not separate: slots, verdicts and bounds, and
                        ///< kinds where requested; and the times of their sweeps
    /// Pairs with a body that Bodies::set_motion() moved, ascending. If the bodies did not meet on the way, the result
    /// in `pairs` is separate, with a bound > 0; otherwise it has the verdict and the gap of the sweep.
    std::span<const PairSweep> sweeps;
};

// --- Queries.

/// A list for each of many queries: items[offsets[i]] up to items[offsets[i + 1]] belong to query i.
template <class Item>
struct Lists {
    std::vector<Item> items;
    std::vector<std::size_t> offsets; ///< one more than there are queries; the first is 0

    std::size_t size() const { return offsets.empty() ? 0 : offsets.size() - 1; } ///< number of queries
    std::span<const Item> operator[](std::size_t query) const
    {
        return std::span(items).subspan(offsets[query], offsets[query + 1] - offsets[query]);
    }
};

/// A body that a query could not rule out: its verdict is never separate.
struct QueryHit : Finding {
    BodyId body;
};

/// A body near a model at a pose.
struct BodyDistance {
    BodyId body;
    Distance distance;
};

/// The first contact of a moving model with a body.
struct SweepHit : SweepResult {
    BodyId body; ///< null: there is no contact
};

/// The manifolds of many pairs: regions[offsets[i]] up to regions[offsets[i + 1]] belong to pair i, and name their
/// points.
struct ManifoldLists {
    std::vector<ManifoldRegion> regions;
    std::vector<ManifoldPoint> points;
    std::vector<std::size_t> offsets;   ///< one more than there are pairs; the first is 0
    std::vector<std::uint8_t> complete; ///< for each pair: Manifold::complete
};

/// The manifolds of a frame: of its pairs that have a region, or whose manifold is not complete, in the frame's order.
struct FrameManifolds : ManifoldLists {
    std::vector<PairOfBodies> pairs;
};

/// Depends on all bits of the lists.
ONCOLLIDE_API std::uint64_t hash_of(const ManifoldLists& manifolds);

/// The first point of a segment in bodies. Fractions run from 0 at the segment's first point to 1 at its last, for its
/// points moved into the body's frame in double.
struct CastHit {
    BodyId body; ///< null: nothing was hit
    /// colliding: certainly hit. within: rounding hides whether the segment touches a round shape. undecided: a file
    /// could not be read, or a budget has no room for the mesh's tree.
    Verdict verdict = Verdict::separate;
    /// Certified bounds of the fraction at the first common point; both 0 for a segment that begins in a solid or on a
    /// surface. Relative width 2^-46; for round shapes 2^-40 of the segment, more where it grazes the shape.
    double fraction_lower = 0, fraction_upper = 0;
    Eigen::Vector3d point = Eigen::Vector3d::Zero(); ///< world frame, metres: on the segment, between the fractions
    /// World frame, unit, facing the segment's first point. 0 where it is not defined: the segment begins in a solid,
    /// or lies in the triangle's plane; or the hit is undecided.
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    BodyPart part{};
};

} // namespace oncollide

template <>
struct std::hash<oncollide::BodyId> {
    std::size_t operator()(oncollide::BodyId id) const noexcept
    {
        return std::hash<std::uint64_t>()(std::uint64_t{id.world} << 48 | std::uint64_t{id.generation} << 32 | id.slot);
    }
};
template <>
struct std::hash<oncollide::ModelId> {
    std::size_t operator()(oncollide::ModelId id) const noexcept
    {
        return std::hash<std::uint64_t>()(std::uint64_t{id.world} << 48 | std::uint64_t{id.generation} << 32 | id.slot);
    }
};
