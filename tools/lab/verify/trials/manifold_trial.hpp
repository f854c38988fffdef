#pragma once
#include <cstdint>
#include <functional>

#include "verify/trials/seeds.hpp"

namespace oncollide::tools {

/// Manifolds of small closed meshes in general position, judged by rational arithmetic (oracle/manifold_truth.hpp).
struct ManifoldTally {
    std::uint64_t pairs = 0, met = 0; ///< met: the surfaces cross
    std::uint64_t whole = 0;          ///< one region, of which all claims were tested
    std::uint64_t exact = 0;          ///< decided by rational arithmetic; the rest by long double with a margin
    std::uint64_t special = 0;        ///< not in general position: not tested
    std::uint64_t contacts = 0;
    std::uint64_t faults = 0;
    FirstFault first;

    ManifoldTally& operator+=(const ManifoldTally& o);
};

/// The pairs of `count` seeds from `first` on: two of a tetrahedron, a cuboid and two concave prisms, all with random
/// corners. Does not depend on the number of threads.
ManifoldTally try_manifolds(std::uint64_t first, std::uint64_t count, int threads, const std::function<void()>& done);

} // namespace oncollide::tools
