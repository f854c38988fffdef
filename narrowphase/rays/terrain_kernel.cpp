// Compiled once per instruction set; see oncollide_add_kernel.
#include <oncollide/base/simd/simd_vectors.hpp>
#include <oncollide/narrowphase/rays/terrain_kernel.hpp>

namespace oncollide::ONCOLLIDE_ISA {
namespace {

/// The lines before and after each lane's column and row.
struct Lanes {
    F32x8 x[2], y[2];
};
inline Lanes lanes_of(const TerrainBlocks& b)
{
    const float(&x)[5] = b.x, (&y)[5] = b.y;
    Lanes lanes;
    for (int side = 0; side < 2; ++side) {
        const float *const u = x + side, *const v = y + side;
        if (b.wide) {
            lanes.x[side] = F32x8{u[0], u[1], u[2], u[3], u[0], u[1], u[2], u[3]};
            lanes.y[side] = F32x8{v[0], v[0], v[0], v[0], v[1], v[1], v[1], v[1]};
        } else {
            lanes.x[side] = F32x8{u[0], u[1], u[0], u[1], u[0], u[1], u[0], u[1]};
            lanes.y[side] = F32x8{v[0], v[0], v[1], v[1], v[2], v[2], v[3], v[3]};
        }
    }
    return lanes;
}

unsigned blocks(const TerrainBlocks& b, const TerrainLine& line, float last, float (&entry)[8])
{
    const Lanes lanes = lanes_of(b);
    const F32x8 low[3] = {lanes.x[0], lanes.y[0], load(b.low) + (b.zero - b.margin)},
                high[3] = {lanes.x[1], lanes.y[1], load(b.high) + (b.zero + b.margin)};
    F32x8 enters = splat(0), leaves = splat(last);
#pragma GCC unroll 3
    for (int i = 0; i < 3; ++i) {
        const bool up = line.ray.inverse[i] > 0;
        const F32x8 from = (low[i] - line.ray.from_more[i]) * line.ray.inverse[i],
                    to = (high[i] - line.ray.from_less[i]) * line.ray.inverse[i];
        enters = max(enters, up ? from : to), leaves = min(leaves, up ? to : from);
    }
    store(entry, enters);
    const I32x8 meets = enters <= leaves;
    // The line's height over the middle plane's slopes, where it enters and leaves.
    const F32x8 sx = load(b.slope_x), sy = load(b.slope_y), steep = abs(sx) + abs(sy), slab_low = load(b.slab_low),
                slab_high = load(b.slab_high);
    const F32x8 middle_x = b.one_slope ? splat(b.x[0] + 2 * b.half_x) : lanes.x[0] + b.half_x,
                middle_y = b.one_slope ? splat(b.y[0] + 4 * b.half_y) : lanes.y[0] + b.half_y;
    const F32x8 over = (line.from[2] - b.zero) - sx * (line.from[0] - middle_x) - sy * (line.from[1] - middle_y);
    const F32x8 rise = line.direction[2] - sx * line.direction[0] - sy * line.direction[1];
    const F32x8 first = over + enters * rise, then = over + leaves * rise;
    const F32x8 slack = b.margin + box_margin * (8 * (b.half_x + b.half_y) * steep + (slab_high - slab_low)) +
                        4 * line.error * (1 + steep);
    const I32x8 misses = (max(first, then) < slab_low - slack) | (min(first, then) > slab_high + slack);
    return bits(meets & ~misses);
}

/// Twice the area that the line makes with the side from p to q, as it is seen along the line.
inline F32x8 area(const Vec& along, const Vec& p, const Vec& q)
{
    return dot(along, cross(p, q));
}

inline RayHits hits(F32x8 a, F32x8 b, F32x8 c, F32x8 limit, I32x8 there)
{
    const F32x8 least = min(a, min(b, c)), most = max(a, max(b, c));
    return {bits(there & ((least >= -limit) | (most <= limit))), bits(there & ((least > limit) | (most < -limit)))};
}

/// The signs of the areas that the line makes with the three sides are equal if it meets the triangle.
CellHits cells(const TerrainCells& c, const float (&direction)[3], float error)
{
    const float(&x)[5] = c.x, (&y)[3] = c.y, (&z)[3][5] = c.z;
    const auto row = [](const float(&low)[5], const float(&high)[5], int i) {
        return F32x8{low[i], low[i + 1], low[i + 2], low[i + 3], high[i], high[i + 1], high[i + 2], high[i + 3]};
    };
    const F32x8 x0 = row(x, x, 0), x1 = row(x, x, 1), y0{y[0], y[0], y[0], y[0], y[1], y[1], y[1], y[1]},
                y1{y[1], y[1], y[1], y[1], y[2], y[2], y[2], y[2]};
    const Vec least{x0, y0, row(z[0], z[1], 0)}, right{x1, y0, row(z[0], z[1], 1)}, up{x0, y1, row(z[1], z[2], 0)},
        greatest{x1, y1, row(z[1], z[2], 1)};
    const Vec along{splat(direction[0]), splat(direction[1]), splat(direction[2])};
    const F32x8 heights = least.z + right.z + up.z + greatest.z;
    const I32x8 there = heights == heights; // no hole
    const auto square = [](F32x8 v) { return v * v; };
    const F32x8 size2 = max(square(x0), square(x1)) + max(square(y0), square(y1)) +
                        max(max(square(least.z), square(right.z)), max(square(up.z), square(greatest.z)));
    const F32x8 limit = 4 * sqrt(size2) * error + 0x1p-17f * size2 + 1e-36f;
    const F32x8 low = area(along, least, right), far = area(along, right, greatest), high = area(along, greatest, up),
                near = area(along, up, least), rising = area(along, greatest, least), falling = area(along, right, up);
    const I32x8 falls = (static_cast<std::int32_t>(c.falling) & I32x8{1, 2, 4, 8, 16, 32, 64, 128}) != 0;
    CellHits found;
    found.even = hits(low, falls ? falling : far, falls ? near : rising, limit, there);
    found.odd = hits(high, falls ? far : near, falls ? -falling : -rising, limit, there);
    float sizes[8], most = 0;
    store(sizes, size2);
    for (const float size : sizes) most = size > most ? size : most; // NaN is never more
    found.reach = __builtin_sqrtf(most) * (1 + 0x1p-20f);
    return found;
}

} // namespace

TerrainRayKernel terrain_ray_kernel()
{
    return {blocks, cells};
}

} // namespace oncollide::ONCOLLIDE_ISA
