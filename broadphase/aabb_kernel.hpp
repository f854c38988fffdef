// The hot loops of the broad phase, compiled once per instruction set. Plain data in, plain data out.
#pragma once
#include <cstdint>

namespace oncollide {

/// Float AABBs as columns, rounded outward. Readable for 8 boxes past the last one used.
struct AabbColumnsView {
    const float* lo[3];
    const float* hi[3];
};

/// Writes to `out` the positions in [begin, end) whose box overlaps `box` (lo x y z, hi x y z; closed), ascending.
/// `out` needs room for end - begin + 8. Returns the number of positions.
using OverlapRange = std::uint32_t(const AabbColumnsView& columns, std::uint32_t begin, std::uint32_t end,
                                   const float box[6], std::uint32_t* out);

/// Smallest and largest of rows * point over `count` points (a multiple of 8; float columns x, y, z; rows 3x3
/// row-major).
using SupportBox = void(const float* x, const float* y, const float* z, std::uint32_t count, const float rows[9],
                        float lo[3], float hi[3]);

/// A list of points in the columns. It begins at a multiple of 8 and is readable up to the next multiple of 8 after its
/// end.
struct PointRange {
    std::uint32_t begin, count;
};

/// As SupportBox, but lists[2 k] holds the candidates for the maximum along row k, lists[2 k + 1] for the minimum.
using ListsBox = void(const float* x, const float* y, const float* z, const PointRange lists[6], const float rows[9],
                      float lo[3], float hi[3]);

/// Largest of direction * point over points as in SupportBox.
using MostAlong = float(const float* x, const float* y, const float* z, std::uint32_t count, const float direction[3]);

/// The index of a support point along `direction`.
using Farthest = std::uint32_t(const float* x, const float* y, const float* z, std::uint32_t count,
                               const float direction[3]);

/// keep[i] = 0 if one other point exceeds point i along all four directions by more than `rounding`, else 1. Only five
/// other points are tried: the support points along the four directions and along their sum. `keep` has room for
/// `count` rounded up to 8, `along` (the projections) for five times as many.
using KeepFarthest = void(const float* x, const float* y, const float* z, std::uint32_t count,
                          const float (&directions)[4][3], float rounding, float* along, std::int32_t* keep);

struct AabbKernel {
    OverlapRange* overlap_range;
    SupportBox* support_box;
    ListsBox* lists_box;
    MostAlong* most_along;
    Farthest* farthest;
    KeepFarthest* keep_farthest;
};

namespace baseline {
AabbKernel aabb_kernel();
}
namespace avx2 {
AabbKernel aabb_kernel();
}
namespace avx512 {
AabbKernel aabb_kernel();
}

/// The implementation for instruction_set().
const AabbKernel& aabb_kernel();

} // namespace oncollide
