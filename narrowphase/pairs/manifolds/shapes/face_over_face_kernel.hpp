// The common part of two boxes' faces, one implementation per instruction set. Plain data in, plain data out.
#pragma once

namespace oncollide {

/// A parallelogram, seen over a rectangle. x and y along the rectangle's sides, z over its plane; metres.
struct FaceOverFace {
    alignas(32) double middle[4], u[4], v[4]; ///< of the parallelogram, and from there to the middles of two sides
    double half_x, half_y;                    ///< of the rectangle, whose middle is 0
    double rounding;                          ///< a corner may lie this far outside of the other
};

/// The corners of the common part as points of the parallelogram. Corner k is at high u for k = 0 and 3, at high v for
/// k = 0 and 1; side k leads to corner k from the one before it. Corners and sides of the rectangle: the same.
struct CommonCorners {
    /// Places where the parallelogram's sides enter and leave the rectangle, its corners, corners of the rectangle.
    enum Kind { entering, leaving, of_upper, of_lower, kinds };
    alignas(32) double x[kinds][4], y[kinds][4], z[kinds][4];
    unsigned there;            ///< bit 4 k + kind: it is a corner; nearly in turns around the common part
    unsigned through_x[kinds]; ///< bit k: side k enters or leaves through a side at an end of x
    unsigned rises_x, rises_y; ///< bit k: x or y rises along side k
};

using FindCommonCorners = void(const FaceOverFace& faces, CommonCorners& found);

namespace baseline {
FindCommonCorners* find_common_corners();
}
namespace avx2 {
FindCommonCorners* find_common_corners();
}

} // namespace oncollide
