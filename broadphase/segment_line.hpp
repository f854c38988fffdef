// Segments for the tests of boxes in kernels. Plain data.
#pragma once

namespace oncollide {

/// The points middle + t half direction with -1 <= t <= 1, metres, in floats relative to an origin; the direction has
/// length 1, or 0 for a point.
///
/// Let P and d be the projections of (centre of a box - middle) and of the direction onto the box's axes, and h its
/// half-extents. If the segment meets the box, |P_i| <= h_i + half |d_i| for each axis, and |P_i d_j - P_j d_i| <= h_i
/// |d_j| + h_j |d_i| for each two axes: these are all separating axes of a box and a segment. `error` widens h, and
/// `cross_error` the second bound: together they exceed the rounding.
struct SegmentLine {
    float middle[3], direction[3];
    float half;
    float error, cross_error;
};

} // namespace oncollide
