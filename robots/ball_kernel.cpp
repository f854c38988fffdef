// Compiled once per instruction set; see oncollide_add_kernel.
#include <oncollide/base/simd/simd.hpp>
#include <oncollide/robots/ball_kernel.hpp>

namespace oncollide::ONCOLLIDE_ISA {
namespace {

struct Point {
    F32x8 x, y, z;
    F32x8 square() const { return x * x + y * y + z * z; }
};

inline Point load_point(const BallColumns& columns, std::uint32_t i)
{
    return {load(columns.x + i), load(columns.y + i), load(columns.z + i)};
}

inline Point moved(const BallFrame& f, Point p)
{
    return {f[0] * p.x + f[1] * p.y + f[2] * p.z + f[3], f[4] * p.x + f[5] * p.y + f[6] * p.z + f[7],
            f[8] * p.x + f[9] * p.y + f[10] * p.z + f[11]};
}

inline F32x8 beyond(F32x8 x, float half)
{
    return max(abs(x) - half, F32x8{});
}

/// The vector to the point from the nearest point of the box.
inline Point outside(Point p, const float (&half)[3])
{
    return {beyond(p.x, half[0]), beyond(p.y, half[1]), beyond(p.z, half[2])};
}

/// Bits of the balls i to i + 7 whose distance is at most the grown radius.
template <class Distance>
inline unsigned near_eight(const BallColumns& balls, std::uint32_t i, BallGrowth growth, Distance distance)
{
    const F32x8 within = load(balls.radius + i) * growth.factor + growth.slack;
    return bits(distance(load_point(balls, i)).square() <= within * within);
}

template <class Distance>
inline std::uint32_t near_balls(const BallBlocks& all, BallGrowth growth, std::uint32_t* out, Distance distance)
{
    std::uint32_t found = 0;
    for (std::uint32_t first = 0; first < all.blocks; first += 8)
        for (unsigned blocks = near_eight(all.around, first, growth, distance); blocks; blocks &= blocks - 1) {
            const std::uint32_t ball = 8 * (first + static_cast<std::uint32_t>(__builtin_ctz(blocks)));
            for (unsigned near = near_eight(all.balls, ball, growth, distance); near; near &= near - 1)
                out[found++] = ball + static_cast<std::uint32_t>(__builtin_ctz(near));
        }
    return found;
}

std::uint32_t balls_near_ball(const BallBlocks& blocks, const BallFrame& frame, const float (&ball)[4],
                              BallGrowth growth, std::uint32_t* out)
{
    growth.slack += ball[3];
    return near_balls(blocks, growth, out, [&](Point p) {
        p = moved(frame, p);
        return Point{p.x - ball[0], p.y - ball[1], p.z - ball[2]};
    });
}

std::uint32_t balls_near_box(const BallBlocks& blocks, const BallFrame& frame, const float (&half)[3],
                             BallGrowth growth, std::uint32_t* out)
{
    return near_balls(blocks, growth, out, [&](Point p) { return outside(moved(frame, p), half); });
}

void points_near(const BallColumns& a, const BallColumns& b, std::uint32_t count, float reach, std::uint8_t* near)
{
    for (std::uint32_t i = 0; i < count; i += 8) {
        const Point p = load_point(a, i), q = load_point(b, i);
        const Point apart{p.x - q.x, p.y - q.y, p.z - q.z};
        near[i / 8] = static_cast<std::uint8_t>(bits(apart.square() <= splat(reach * reach)));
    }
}

void points_near_box(const BallColumns& points, std::uint32_t count, const BallFrame& frame, const float (&half)[3],
                     float reach, std::uint8_t* near)
{
    for (std::uint32_t i = 0; i < count; i += 8)
        near[i / 8] = static_cast<std::uint8_t>(
            bits(outside(moved(frame, load_point(points, i)), half).square() <= splat(reach * reach)));
}

bool a_ball_meets_box(const BallColumns& balls, std::uint32_t count, const BallFrame& frame, const float (&half)[3],
                      bool points_only)
{
    const float most = points_only ? 0 : __builtin_inff();
    for (std::uint32_t i = 0; i < count; i += 8) {
        const F32x8 radius = load(balls.radius + i),
                    square = outside(moved(frame, load_point(balls, i)), half).square();
        if (bits((square <= radius * radius) & (radius >= 0) & (radius <= splat(most)))) return true;
    }
    return false;
}

} // namespace

BallKernel ball_kernel()
{
    return {balls_near_ball, balls_near_box, points_near, points_near_box, a_ball_meets_box};
}

} // namespace oncollide::ONCOLLIDE_ISA
