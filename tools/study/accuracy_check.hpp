#pragma once
#include <cstdint>
#include <string>

#include "peers/fcl_world.hpp"
#include <oncollide/runs/pipeline.hpp>

// Compares a frame of the pipeline with FCL's result for the same frame.
namespace oncollide::tools {

/// Comparison of a frame's pairs with FCL's. Sums over frames with +=.
struct Comparison {
    std::uint64_t pairs = 0;     ///< candidates of the broad phase
    std::uint64_t left_over = 0; ///< not separate: within, undecided or colliding
    std::uint64_t undecided = 0;
    std::uint64_t colliding = 0;       ///< by the exact level
    std::uint64_t fcl_colliding = 0;   ///< by FCL
    std::uint64_t false_positives = 0; ///< left over, but not colliding for FCL
    std::uint64_t missed = 0;          ///< colliding for FCL, but not left over: must be 0
    /// Colliding for FCL, but not left over, where a shape takes part and the overlap is below `shape_rounding`.
    std::uint64_t missed_by_rounding = 0;
    /// `colliding` although FCL says no and, for pairs with a shape, extended precision also says no. 0 with exact fcl.
    std::uint64_t wrong_exact = 0;
    std::string first_missed; ///< names of the bodies
    Comparison& operator+=(const Comparison& other);
};

/// libccd, which FCL uses for primitive shapes, stops within 1e-6; overlaps and gaps below this may be its error (m).
constexpr double shape_rounding = 1e-5;

/// @param world  in the state in which it computed `fcl`
Comparison compare(const Scene& scene, const FrameView& frame, const Settings& settings, const FclFrame& fcl,
                   const FclWorld& world);

/// Comparison of a frame's certified bounds with FCL's distances.
struct BoundCheck {
    std::uint64_t checks = 0, violations = 0;
    double least_margin = 1e300; ///< smallest bound - distance (within) or distance - bound (separate), m
    double largest_bound = 0;    ///< of `within` pairs, m
    std::string first_violation;
    BoundCheck& operator+=(const BoundCheck& other);
};

/// Checks one pair. `distance` is FCL's.
BoundCheck check_bound(const Scene& scene, const PairResult& pair, const Settings& settings, double distance,
                       bool has_shape);

} // namespace oncollide::tools
