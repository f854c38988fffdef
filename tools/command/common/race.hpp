#pragma once
#include <algorithm>
#include <cstddef>
#include <limits>

#include "common/statistics.hpp"

// How all benchmarks compare: contenders take turns, so that none is always first, and the least of the repeats counts.
namespace oncollide::tools {

/// Calls run(k) for each contender below `count`, beginning with another one in each round.
template <class Run>
void take_turns(std::size_t count, std::size_t round, Run run)
{
    for (std::size_t k = 0; k < count; ++k) run((k + round) % count);
}

/// The least time between two readings of the clock, milliseconds: part of every measured time.
inline double clock_ms()
{
    static const double cost = [] {
        double least = std::numeric_limits<double>::infinity();
        for (int k = 0; k < 1000; ++k) least = std::min(least, milliseconds_since(Clock::now()));
        return least;
    }();
    return cost;
}

/// Milliseconds of the fastest of at most `repeats` calls of work(), without clock_ms(); stops once the calls have
/// taken `enough`.
template <class Work>
double least_ms(int repeats, Work work, double enough = std::numeric_limits<double>::infinity())
{
    double least = std::numeric_limits<double>::infinity(), sum = 0;
    for (int repeat = 0; repeat < repeats && sum < enough; ++repeat) {
        const Clock::time_point from = Clock::now();
        work();
        const double ms = milliseconds_since(from);
        least = std::min(least, ms), sum += ms;
    }
    return std::max(least - clock_ms(), 1e-6); // at least a nanosecond, because ratios divide by it
}

} // namespace oncollide::tools
