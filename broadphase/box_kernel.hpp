// The broad phase's hot loops, one implementation an instruction set. Plain data in, plain data out.
#pragma once
#include <cstdint>

namespace oncollide {

/// Float boxes as columns, rounded outward. Readable for 8 boxes past the last one used.
struct BoxColumnsView {
    const float* lo[3];
    const float* hi[3];
};

/// Positions in [begin, end) whose box overlaps `box` (lo x y z, hi x y z; closed), ascending, to `out` (room for
/// end - begin + 8). Returns how many.
using OverlapRange = std::uint32_t(const BoxColumnsView& columns, std::uint32_t begin, std::uint32_t end,
                                   const float box[6], std::uint32_t* out);

/// Smallest and largest of rows * point over `count` points (a multiple of 8; float columns x, y, z; rows 3x3
/// row-major).
using SupportBox = void(const float* x, const float* y, const float* z, std::uint32_t count, const float rows[9],
                        float lo[3], float hi[3]);

/// Some points of the columns, the first at a multiple of 8; readable up to the next one after the last.
struct PointRange {
    std::uint32_t begin, count;
};

/// The same, each of lists of its own: lists[2 k] holds the points of which one shows the largest along row k, the next
/// one those of the smallest.
using ListsBox = void(const float* x, const float* y, const float* z, const PointRange lists[6], const float rows[9],
                      float lo[3], float hi[3]);

/// Largest of direction * point over points as of SupportBox.
using MostAlong = float(const float* x, const float* y, const float* z, std::uint32_t count, const float direction[3]);

/// The number of a point that shows as much.
using Farthest = std::uint32_t(const float* x, const float* y, const float* z, std::uint32_t count,
                               const float direction[3]);

/// Which of the points no other one exceeds along all of four directions by more than the rounding: 1, else 0. The
/// others tried are those farthest along the four and along their sum. Both outputs have room for `count` rounded up to
/// 8, `along` for five times as many.
using KeepFarthest = void(const float* x, const float* y, const float* z, std::uint32_t count,
                          const float (&directions)[4][3], float rounding, float* along, std::int32_t* keep);

struct BoxKernel {
    OverlapRange* overlap_range;
    SupportBox* support_box;
    ListsBox* lists_box;
    MostAlong* most_along;
    Farthest* farthest;
    KeepFarthest* keep_farthest;
};

namespace baseline {
BoxKernel box_kernel();
}
namespace avx2 {
BoxKernel box_kernel();
}
namespace avx512 {
BoxKernel box_kernel();
}

/// The kernel of instruction_set().
const BoxKernel& box_kernel();

} // namespace oncollide
