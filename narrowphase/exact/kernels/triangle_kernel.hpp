// Tests of triangles against triangles, one implementation per instruction set. Plain data in, plain data out.
#pragma once
#include <cstdint>

namespace oncollide {

/// Pointers to the corners of eight pairs of triangles: [corner][pair], three doubles each.
struct CornersOfPairs {
    const double *a[3][8], *b[3][8];
};

/// One bit per pair: `separate` if it is certainly separate, `known` if it is certain whether it is.
struct PairVerdicts {
    unsigned separate, known;
};

/// Tests triangles of A against triangles of B, which are moved as RelativePose does. `rotation` is column-major.
/// @param nearest2  in and out, for each pair: the least certified squared distance of triangles that were separate;
/// null: not needed
using JudgePairs = PairVerdicts(const CornersOfPairs& corners, const double* rotation, const double* translation,
                                double (*nearest2)[8]);

namespace baseline {
JudgePairs* judge_pairs();
}
namespace avx2 {
JudgePairs* judge_pairs();
}
namespace avx512 {
JudgePairs* judge_pairs();
}

} // namespace oncollide
