#pragma once
#include <chrono>
#include <vector>

namespace oncollide::tools {

// Both functions return 0 for an empty list.
double median(std::vector<double> values);
double mean(const std::vector<double>& values);

using Clock = std::chrono::steady_clock;

inline double milliseconds_since(Clock::time_point from)
{
    return std::chrono::duration<double, std::milli>(Clock::now() - from).count();
}

} // namespace oncollide::tools
