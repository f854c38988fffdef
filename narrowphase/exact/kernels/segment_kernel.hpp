// The common segments of triangles that cross, one implementation per instruction set. Plain data in, plain data out.
#pragma once
#include <oncollide/narrowphase/exact/kernels/triangle_kernel.hpp>

namespace oncollide {

/// p -> rotation p + translation; column-major.
struct RigidMap {
    const double *rotation, *translation;
};

/// Results of eight pairs of triangles: [end][axis][pair], [axis][pair].
struct SegmentsOfPairs {
    double ends[2][3][8];                  ///< ends of the common segment
    double normal_a[3][8], normal_b[3][8]; ///< unit normals
};

/// Common segments of triangles of A and triangles of B, which are moved as RelativePose does. Returns one bit for each
/// pair that certainly crosses and whose results in A's frame certainly have the accuracy below; the other pairs are
/// undecided. `place` is then applied to the results, and adds its own rounding.
///
/// Coordinates of ends err by at most 2^-46 times the largest coordinate, components of normals by at most 2^-40.
using CommonSegments = unsigned(const CornersOfPairs& corners, const RigidMap& b_to_a, const RigidMap& place,
                                SegmentsOfPairs& out);

namespace baseline {
CommonSegments* common_segments();
}
namespace avx2 {
CommonSegments* common_segments();
}
namespace avx512 {
CommonSegments* common_segments();
}

} // namespace oncollide
