// What triangles that cross have in common, one implementation an instruction set. Plain data in, plain data out.
#pragma once
#include <oncollide/narrowphase/exact/triangle_kernel.hpp>

namespace oncollide {

/// p -> rotation p + translation; column-major.
struct RigidMap {
    const double *rotation, *translation;
};

/// Of eight pairs of triangles: [end][axis][pair], [axis][pair].
struct SegmentsOfPairs {
    double ends[2][3][8];                  ///< of what both have in common
    double normal_a[3][8], normal_b[3][8]; ///< unit
};

/// Of triangles of A and triangles of B, moved as RelativePose does: one bit for each pair that certainly crosses and
/// of which all is as accurate as stated, in A's frame; the others are left open. Then `place` moves what is written,
/// with rounding of its own.
///
/// Coordinates of ends err by at most 2^-46 times the largest coordinate, components of normals by 2^-40.
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
