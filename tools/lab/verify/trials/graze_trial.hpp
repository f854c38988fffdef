#pragma once
#include <cstdint>
#include <functional>
#include <string>

#include "verify/trials/seeds.hpp"

namespace oncollide::tools {

/// The results of sweeps that graze.
struct GrazeTally {
    std::uint64_t sweeps = 0, contacts = 0, grazes = 0, clear = 0, open = 0; ///< verdicts; open: undecided
    std::uint64_t faults = 0;
    FirstFault first;

    GrazeTally& operator+=(const GrazeTally& o);
};

/// Bodies of all convex kinds that slide above a floor, into a wall of the same body or past its end, fall through a
/// large plate, or pass a ball. Gaps are 0 or 2^-50 to 2^-8 of the size, sizes 2^-20 to 2^20 m. The truth is a closed
/// form whose numbers are powers of two, or an interval around it. Each is swept in both orders, with all three
/// SweepStops. Returns the first fault; empty: none.
std::string graze_fault(std::uint64_t seed, GrazeTally& tally);

/// Tries `count` seeds from `first` on. Calls done() once per seed, never concurrently. Results do not depend on the
/// number of threads.
GrazeTally try_grazes(std::uint64_t first, std::uint64_t count, int threads, const std::function<void()>& done);

} // namespace oncollide::tools
