#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>

#include <oncollide/narrowphase/finding.hpp>

#include "verify/cases/drawn_scene.hpp"
#include "verify/trials/seeds.hpp"

namespace oncollide::tools {

/// The results of sweeps of two kinds of geometry.
struct SweepTally {
    std::uint64_t sweeps = 0;
    std::uint64_t contacts = 0, at_start = 0, clear = 0,
                  open = 0;    ///< verdicts: on the way; at time 0; none; not decided
    std::uint64_t poses = 0;   ///< judged by the library's exact tests
    std::uint64_t truths = 0;  ///< judged by the truth
    std::uint64_t missed = 0;  ///< sweeps that collide before `clear_until`
    std::uint64_t early = 0;   ///< sweeps without contact at `contact_by`
    std::uint64_t wide = 0;    ///< sweeps whose tolerances do not hold, or whose gap is too small
    std::uint64_t changed = 0; ///< sweeps that contradict the one with the bodies swapped

    std::uint64_t faults() const { return missed + early + wide + changed; }
    SweepTally& operator+=(const SweepTally& o);
};

/// Tallies by the names of both kinds, in alphabetical order.
struct SweepTallies : std::map<std::pair<std::string, std::string>, SweepTally> {
    FirstFault first;

    SweepTallies& operator+=(const SweepTallies& o);
};

/// The sweep of the two bodies as Pairs::sweep() finds it.
/// @param swapped  of b and a
SweepResult sweep_of(const DrawnSweep& drawn, bool swapped = false);

/// The judge of single poses: the truth (truth.hpp; 0.3 ms for each pose), or the exact tests of the library (some
/// microseconds).
enum class PoseJudge : std::uint8_t { truth, exact_tests };

/// Judges single poses of a result: several before `clear_until`, the one just before it, and the one at `contact_by`;
/// and compares the result with the one for the bodies swapped. Returns the first fault; empty: none.
std::string fault_in(const DrawnSweep& drawn, const SweepResult& found, const SweepResult& swapped, std::uint64_t seed,
                     PoseJudge judge, SweepTally& tally);

/// Draws, sweeps and judges `count` seeds from `first` on: the truth judges every 16th, exact tests judge all. Calls
/// done() once per seed, never concurrently. Results do not depend on the number of threads.
SweepTallies try_sweeps(std::uint64_t first, std::uint64_t count, int threads, const std::function<void()>& done);

} // namespace oncollide::tools
