// Balls against boxes and balls, eight at a time, one implementation per instruction set. Plain data in, plain data
// out.
#pragma once
#include <cstdint>

namespace oncollide {

/// Balls in columns.
struct BallColumns {
    const float *x, *y, *z, *radius;
};

/// Balls in blocks of eight, and a ball around each block. Padded with balls that are far from everything.
struct BallBlocks {
    BallColumns balls, around; ///< around: readable up to a multiple of 8 blocks
    std::uint32_t blocks;
};

/// A motion into the frame of the other side: rows of the rotation, each followed by the translation.
using BallFrame = float[12];

/// Radii r count as r * factor + slack.
struct BallGrowth {
    float factor, slack;
};

/// Writes the balls that meet a ball of the other frame. `out` needs room for all balls. Returns their number.
/// @param ball  x, y, z, radius; the radius is not grown
using BallsNearBall = std::uint32_t(const BallBlocks& blocks, const BallFrame& frame, const float (&ball)[4],
                                    BallGrowth growth, std::uint32_t* out);
/// The same, with a box from -half to half.
using BallsNearBox = std::uint32_t(const BallBlocks& blocks, const BallFrame& frame, const float (&half)[3],
                                   BallGrowth growth, std::uint32_t* out);

/// Sets bit i of near[] if points i of both columns are at most `reach` from each other. `count` is a multiple of 8.
using PointsNear = void(const BallColumns& a, const BallColumns& b, std::uint32_t count, float reach,
                        std::uint8_t* near);
/// Sets bit i of near[] if point i, moved by `frame`, is at most `reach` from the box.
using PointsNearBox = void(const BallColumns& points, std::uint32_t count, const BallFrame& frame,
                           const float (&half)[3], float reach, std::uint8_t* near);

/// True if a ball surely meets a box; balls of negative radius do not.
/// @param count        a multiple of 8
/// @param points_only  only balls of radius 0 count
using ABallMeetsBox = bool(const BallColumns& balls, std::uint32_t count, const BallFrame& frame,
                           const float (&half)[3], bool points_only);

struct BallKernel {
    BallsNearBall* balls_near_ball;
    BallsNearBox* balls_near_box;
    PointsNear* points_near;
    PointsNearBox* points_near_box;
    ABallMeetsBox* a_ball_meets_box;
};

namespace baseline {
BallKernel ball_kernel();
}
namespace avx2 {
BallKernel ball_kernel();
}

} // namespace oncollide
