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
struct TriangleKernel {
    PairVerdicts (*judge)(const CornersOfPairs& corners, const double* rotation, const double* translation);
    /// Certified lower bounds on the distances of the triangles; > 0 for pairs that `judge` calls separate, unless
    /// some length leaves 2^-300 to 2^300. Costs half as much again.
    void (*gaps)(const CornersOfPairs& corners, const double* rotation, const double* translation, double (&gaps)[8]);
};

namespace baseline {
TriangleKernel triangle_kernel();
}
namespace avx2 {
TriangleKernel triangle_kernel();
}
namespace avx512 {
TriangleKernel triangle_kernel();
}

} // namespace oncollide
