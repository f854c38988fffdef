#pragma once
#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/narrowphase/ocst.hpp>

namespace oncollide {

/// Two leaf cells whose spheres touch: what decided a pair.
struct LeafPair {
    CellKey a = 0, b = 0; ///< 0: none
};

/// How a pair's walk stands.
enum class WalkStatus : std::uint8_t {
    separate,  ///< no leaves touch; bound: certified lower bound on the distance
    touching,  ///< two leaves touch; bound: certified upper bound on the distance
    parked,    ///< needs cells that are not expanded
    undecided, ///< such a cell was refused and no leaves are known to touch; bound: certified upper bound so far
};

struct WalkResult {
    WalkStatus status = WalkStatus::parked;
    double bound = 0;
    LeafPair leaves;
};

/// Two bodies at one frame, as the walk sees them.
struct WalkPair {
    Ocst *a, *b;
    std::uint32_t tree_a, tree_b;
    const Eigen::Isometry3d *pose_a, *pose_b;
    double clearance; ///< metres, >= 0
    LeafPair hint;    ///< what decided the pair last frame
};

struct WalkPlan;
struct WalkEntry;

/// A cell to expand before walks can go on.
struct CellRequest {
    std::uint32_t tree;
    CellKey cell;
    friend bool operator==(const CellRequest&, const CellRequest&) = default;
    friend auto operator<=>(const CellRequest&, const CellRequest&) = default;
};

/// Walks pairs of sphere-trees, one thread's worth of state.
///
/// A walk goes down both trees at once, the larger sphere first, both when they are of similar size, depth first and
/// the closest pair first. Where it needs a cell that is not expanded it leaves that pair of cells parked and goes on
/// with the rest; what is parked when nothing else is left becomes requests. So a round opens all it needs at once, and
/// the rounds of a frame are at most the steps of the longest walk, however many pairs there are.
///
/// Bounds. With cells of radius rA, rB, reaches eA, eB (Ocst::reach), clearance c and rounding s, touching leaves mean
/// distance <= |cA - cB| + rA + rB + eA + eB <= c + 2 (rA + rB) + eA + eB + 2 s: the same for every pair of leaves, so the
/// answer does not depend on the order of the walk. If no leaves touch, the smallest |cA - cB| - rA - rB - s over the
/// pairs that were cut is a lower bound.
class Walker {
public:
    Walker();
    ~Walker();
    Walker(Walker&&) noexcept;

    /// Starts a pair. Parked work is appended to this walker's list; its range goes to first and count.
    WalkResult start(const WalkPair& pair, std::uint32_t frame, const OcclusionBackend& backend, std::size_t& first,
                     std::size_t& count);
    /// Goes on with work parked in `from` (another walker or round), given the last result.
    /// @param give_up  cells were refused: take what is not expanded as undecided instead of parking again
    WalkResult resume(const WalkPair& pair, std::uint32_t frame, const OcclusionBackend& backend, const Walker& from,
                      const WalkResult& so_far, bool give_up, std::size_t& first, std::size_t& count);
    /// Appends the cells that a range of parked work needs.
    void requests(const WalkPair& pair, std::size_t first, std::size_t count, std::vector<CellRequest>& out) const;

    /// Forgets parked work; keeps its memory.
    void clear() { parked_used_ = 0; }
    std::uint64_t node_pairs() const { return node_pairs_; }
    void reset_counters() { node_pairs_ = 0; }

private:
    WalkResult run(const WalkPair& pair, const WalkPlan& plan, double rounding, const OcclusionBackend& backend,
                   std::uint32_t top, double lower_so_far, bool give_up, std::size_t& first, std::size_t& count);

    std::vector<WalkEntry> stack_, parked_; ///< parked_ is filled up to parked_used_
    std::size_t parked_used_ = 0;
    std::uint64_t node_pairs_ = 0;
};

} // namespace oncollide
