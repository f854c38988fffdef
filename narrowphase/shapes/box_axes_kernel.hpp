// The separating axes of two boxes, one implementation per instruction set. Plain data in, plain data out.
#pragma once

namespace oncollide {

/// Two boxes in A's frame, by vectors of three numbers.
struct TwoBoxes {
    const double *half_a, *half_b;
    const double* rotation; ///< of B, column by column: its axes
    const double* between;  ///< from A's middle to B's
};

/// How far the boxes overlap along each axis; < 0: they are apart.
struct BoxOverlaps {
    alignas(32) double of_a[4], of_b[4]; ///< along the faces' normals; infinite for a face without area, and the fourth
    alignas(32) double of_edges[3][4];   ///< [axis of B][axis of A]: along their product, times its length
    alignas(32) double length2[3][4];    ///< square of the product's length
    unsigned open; ///< bit 4 j + i: edges along axis i of A and axis j of B may overlap less than all faces
};

/// @param rounding  metres: of each overlap and each product
using OverlapBoxes = void(const TwoBoxes& boxes, double rounding, BoxOverlaps& found);

namespace baseline {
OverlapBoxes* overlap_boxes();
}
namespace avx2 {
OverlapBoxes* overlap_boxes();
}

} // namespace oncollide
