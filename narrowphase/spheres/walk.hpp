#pragma once
#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/narrowphase/spheres/ocst.hpp>

namespace oncollide {

/// Two leaf cells whose spheres touch, which decided a pair.
struct LeafPair {
    CellKey a = 0, b = 0; ///< 0: none
};

/// The state of a pair's traversal.
enum class WalkStatus : std::uint8_t {
    separate,  ///< no leaves touch; bound: certified lower bound on the distance
    touching,  ///< two leaves touch; bound: certified upper bound on the distance
    parked,    ///< needs cells that are not expanded
    undecided, ///< a needed cell was refused and no leaves are known to touch; bound: certified upper bound so far
};

struct WalkResult {
    WalkStatus status = WalkStatus::parked;
    double bound = 0;
    LeafPair leaves;
};

/// Two bodies in one frame, as input of the traversal.
struct WalkPair {
    Ocst *a, *b;
    std::uint32_t tree_a, tree_b;
    int depth_a, depth_b; ///< levels of the leaves that decide, at most the trees' depths
    const Eigen::Isometry3d *pose_a, *pose_b;
    double clearance; ///< metres, >= 0
    LeafPair hint;    ///< the leaves that decided the pair in the last frame
};

struct WalkPlan;
struct WalkEntry;

/// The rest of a parked traversal: entries [first, first + count) of its walker's list, to be resumed from the last;
/// the last `wanted` of them wait for cells.
struct ParkedWork {
    std::size_t first = 0, count = 0, wanted = 0;
};

/// A cell to expand before traversals can continue.
struct CellRequest {
    std::uint32_t tree;
    CellKey cell;
    friend bool operator==(const CellRequest&, const CellRequest&) = default;
    friend auto operator<=>(const CellRequest&, const CellRequest&) = default;
};

/// Traverses pairs of sphere-trees; holds the state of one thread.
///
/// A traversal descends both trees together, depth first and the closest pair first. It descends the larger sphere, or
/// both if they are of similar size. If it needs a cell that is not expanded, it sets that pair of cells aside and
/// continues with the next, until `patience` pairs are set aside. Then it parks, and these pairs become requests. A
/// small patience requests few cells that a touching pair does not need; a large one needs fewer rounds. patience_in()
/// starts small and doubles once a pair has had one round for each of its levels, so the number of rounds in a frame
/// depends on the depth, not on the number of pairs.
///
/// Bounds: with cells of radius rA, rB, errors eA, eB (Ocst::error), clearance c and rounding s, touching leaves imply
/// distance <= |cA - cB| + rA + rB + eA + eB <= c + 2 (rA + rB) + eA + eB + 2 s. This is the same for every pair of
/// leaves, so the result does not depend on the order of the traversal. If no leaves touch, the smallest |cA - cB| - rA
/// - rB - s over the rejected pairs is a lower bound.
class Walker {
public:
    Walker();
    ~Walker();
    Walker(Walker&&) noexcept;

    /// Starts a pair. If the traversal parks, the remaining work is appended to this walker's list of parked work.
    WalkResult start(const WalkPair& pair, std::uint32_t frame, ParkedWork& parked);
    /// Continues work parked in `from` (another walker or round), given the last result.
    /// @param round    1 for the first resumption in a frame
    /// @param give_up  cells were refused: treat unexpanded cells as undecided instead of parking again
    WalkResult resume(const WalkPair& pair, std::uint32_t frame, const Walker& from, const WalkResult& so_far,
                      int round, bool give_up, ParkedWork& parked);
    /// Appends the cells that parked work waits for.
    void requests(const WalkPair& pair, const ParkedWork& parked, std::vector<CellRequest>& out) const;

    static constexpr std::size_t bytes_per_parked = 40; ///< per entry of parked work

    /// Drops parked work; keeps its memory.
    void clear() { parked_used_ = 0; }
    std::uint64_t node_pairs() const { return node_pairs_; }
    void reset_counters() { node_pairs_ = 0; }

private:
    WalkResult run(const WalkPair& pair, const WalkPlan& plan, double rounding, std::uint32_t top, double lower_so_far,
                   std::uint32_t patience, bool give_up, ParkedWork& parked);
    void park(const WalkEntry* entries, std::size_t count);

    std::vector<WalkEntry> stack_, aside_, parked_; ///< parked_ is filled up to parked_used_
    std::size_t parked_used_ = 0;
    std::uint64_t node_pairs_ = 0;
};

} // namespace oncollide
