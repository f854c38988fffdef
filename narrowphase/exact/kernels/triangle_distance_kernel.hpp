// Nearest points of triangles, one implementation per instruction set. Plain data in, plain data out.
#pragma once
#include <oncollide/narrowphase/exact/kernels/triangle_kernel.hpp>

namespace oncollide {

/// For each pair: the nearest points, x, y and z, in A's frame, and their squared distance.
struct NearestOfPairs {
    double a[3][8], b[3][8];
    double distance2[8];
};

/// Measures the first `count` pairs, of triangles that do not meet; B's are moved as RelativePose does. All eight pairs
/// must be readable. `rotation` is column-major. Returns bits of the pairs that may be nearer than their distance minus
/// `rounding`; the others certainly are not.
using MeasurePairs = unsigned(const CornersOfPairs& corners, const double* rotation, const double* translation,
                              unsigned count, double rounding, NearestOfPairs& out);

namespace baseline {
MeasurePairs* measure_pairs();
}
namespace avx2 {
MeasurePairs* measure_pairs();
}
namespace avx512 {
MeasurePairs* measure_pairs();
}

} // namespace oncollide
