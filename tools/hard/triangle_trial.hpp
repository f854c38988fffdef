#pragma once
#include "hard/tally.hpp"
#include "hard/triangle_families.hpp"

namespace oncollide::tools {

/// `count` pairs of a family, as stored on their grid of 2^-20 m or each turned at random and rounded: the exact test
/// in both orders of the triangles, and FCL's, against the oracle. The same pairs for any number of threads. Cost: 10
/// to 100 microseconds a pair.
Tally try_triangles(const TriangleFamily& family, std::uint64_t count, bool rotated, int threads);

} // namespace oncollide::tools
