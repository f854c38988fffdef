// The balls of two meshes against each other, one implementation an instruction set. Plain data in, plain data out.
#pragma once
#include <cstdint>

namespace oncollide {

/// Balls as columns, padded to a multiple of 8 with balls of radius -1e30. At most `most_spheres`.
struct SphereColumns {
    const float *x, *y, *z, *r;
    std::uint32_t count;
    float radius; ///< of a ball around all, from 0
};
constexpr std::uint32_t most_spheres = 48;

struct SphereOverlap {
    float depth;    ///< the most that two balls reach into each other; 0 or less: none were seen to
    float beyond_a; ///< so far from the centre of A's coordinates do B's balls reach
    float beyond_b; ///< and A's from that of B's
};

/// @param rotation  of B's balls into A's coordinates, row-major
using OverlapSpheres = SphereOverlap(const SphereColumns& a, const SphereColumns& b, const float (&rotation)[9],
                                 const float (&translation)[3]);

namespace baseline {
OverlapSpheres* overlap_spheres();
}
namespace avx2 {
OverlapSpheres* overlap_spheres();
}

} // namespace oncollide
