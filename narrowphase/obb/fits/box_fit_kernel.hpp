// Kernels for fitting boxes around triangles, one implementation per instruction set. Plain data in, plain data out.
#pragma once
#include <cstddef>
#include <cstdint>

namespace oncollide {

/// One triangle of each of eight boxes, or eight of one box, indexed by corner, axis and lane.
struct alignas(32) EightTriangles {
    double corners[3][3][8];
};

/// Eight boxes as BoxNode stores them: in steps of its unit from its origin, with the axes as quaternions.
struct StoredBoxes {
    std::int16_t place[3][8];
    std::int16_t turn[4][8]; ///< w, x, y, z
    std::uint16_t half[3][8];
};
struct StoredFrame {
    float origin[3], unit;
};
constexpr double most_place = 32767, most_half = 65535, quaternion_steps = 32767; ///< largest numbers in StoredBoxes

struct BoxFitKernel {
    /// Fits eight boxes, each around triangles of its own. Its axes follow the spread of the triangles' surface
    /// (Gottschalk, Lin and Manocha, "OBBTree", SIGGRAPH 1996); for one triangle they follow its normal and its longest
    /// side or, with a right angle, a leg. They are the frame's axes if that box has less area and is not thicker.
    /// Conservative: the box as read by the box test holds every point of the triangles. Does not depend on the order
    /// of a box's triangles, nor on the order of the corners of several triangles.
    /// @param rows    the triangles of box k are in lane k of the first counts[k] rows; the rows after these repeat one
    /// @param counts  at most 2^14; 0: no box, and everything stored is 0
    void (*fit)(const EightTriangles* rows, const std::uint32_t (&counts)[8], const StoredFrame& frame,
                StoredBoxes& out);
    /// The same for one box of at least eight triangles: triangle i is in lane i % 8 of row i / 8. All eight boxes that
    /// it stores are that box.
    void (*fit_one)(const EightTriangles* rows, const std::uint32_t (&counts)[8], const StoredFrame& frame,
                    StoredBoxes& out);
    /// For each number, counts the numbers that are less. Both arrays must be accessible up to a multiple of 8
    /// elements.
    void (*count_less)(const float* numbers, std::size_t size, std::int32_t* less);
};

namespace baseline {
BoxFitKernel box_fit_kernel();
}
namespace avx2 {
BoxFitKernel box_fit_kernel();
}

} // namespace oncollide
