#pragma once
#include <cstdint>

#include "truth/tally.hpp"
#include "verify/cases/triangle_families.hpp"

namespace oncollide::tools {

/// Another library's test of two triangles.
using TrianglesMeet = bool (*)(const TrianglePoints& a, const TrianglePoints& b);

/// `count` pairs of a family, as stored on their grid of 2^-20 m, or randomly rotated and rounded. Compares the exact
/// test, in both orders of the triangles, and FCL's test, if given, with the oracle. The pairs do not depend on the
/// number of threads. Cost: 10 to 100 microseconds per pair.
Tally try_triangles(const TriangleFamily& family, std::uint64_t count, bool rotated, int threads,
                    TrianglesMeet fcl = nullptr);

} // namespace oncollide::tools
