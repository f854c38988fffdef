// The inner spheres of two meshes against each other, one implementation per instruction set. Plain data in, plain data
// out.
#pragma once
#include <cstdint>

namespace oncollide {

/// Spheres in columns, padded to a multiple of 8 with spheres of radius -1e30. At most `most_spheres`.
struct SphereColumns {
    const float *x, *y, *z, *r;
    std::uint32_t count;
    float radius; ///< radius of the sphere around all of them, centred at 0
};
constexpr std::uint32_t most_spheres = 48;

struct SphereOverlap {
    float depth;    ///< the largest overlap of two spheres; 0 or less: no overlap was found
    float beyond_a; ///< how far B's spheres extend from the origin of A's coordinates
    float beyond_b; ///< how far A's spheres extend from the origin of B's coordinates
};

/// @param rotation  rotates B's spheres into A's coordinates, row-major
using OverlapSpheres = SphereOverlap(const SphereColumns& a, const SphereColumns& b, const float (&rotation)[9],
                                     const float (&translation)[3]);

namespace baseline {
OverlapSpheres* overlap_spheres();
}
namespace avx2 {
OverlapSpheres* overlap_spheres();
}

} // namespace oncollide
