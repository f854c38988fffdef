// Triangles against triangles, one implementation an instruction set. Plain data in, plain data out.
#pragma once
#include <cstdint>

namespace oncollide {

/// Where the corners of eight pairs of triangles are: [corner][pair], three doubles each.
struct CornersOfPairs {
    const double *a[3][8], *b[3][8];
};

/// Bits by pair: those that are certainly separate, and those of which it is certain whether they are.
struct PairVerdicts {
    unsigned separate, known;
};

/// Triangles of A against triangles of B, moved as RelativePose does. `rotation` is column-major.
/// @param nearest2  in and out, by pair: the least squared distance, as certified, of triangles that were separate;
///                  null: nobody wants to know
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
