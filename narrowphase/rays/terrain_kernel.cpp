// Compiled once per instruction set; see oncollide_add_kernel.
#include <oncollide/base/simd/simd_vectors.hpp>
#include <oncollide/narrowphase/obb/terrain_lanes.hpp>
#include <oncollide/narrowphase/rays/terrain_kernel.hpp>

namespace oncollide::ONCOLLIDE_ISA {
namespace {

unsigned blocks(const TerrainBlocks& b, const TerrainLine& line, float last, float (&entry)[8])
{
    const TerrainLanes lanes = lanes_of(b);
    const F32x8 low[3] = {lanes.from[0], lanes.from[1], load(b.low) + (b.zero - b.margin)},
                high[3] = {lanes.to[0], lanes.to[1], load(b.high) + (b.zero + b.margin)};
    F32x8 enters = splat(0), leaves = splat(last);
#pragma GCC unroll 3
    for (int i = 0; i < 3; ++i) {
        const bool up = line.ray.inverse[i] > 0;
        const F32x8 of_low = (low[i] - line.ray.from_more[i]) * line.ray.inverse[i],
                    of_high = (high[i] - line.ray.from_less[i]) * line.ray.inverse[i];
        enters = max(enters, up ? of_low : of_high), leaves = min(leaves, up ? of_high : of_low);
    }
    store(entry, enters);
    const I32x8 meets = enters <= leaves;
    // The line's height over the middle plane's slopes, where it enters and leaves.
    const F32x8 sx = load(b.slope_x), sy = load(b.slope_y), steep = abs(sx) + abs(sy), slab_low = load(b.slab_low),
                slab_high = load(b.slab_high);
    const F32x8 middle_x = b.one_slope ? splat(b.x[0] + 2 * b.half_x) : lanes.from[0] + b.half_x,
                middle_y = b.one_slope ? splat(b.y[0] + 4 * b.half_y) : lanes.from[1] + b.half_y;
    const auto from = [&](int axis) { return line.ray.from_less[axis] + line.error; };
    const F32x8 over = (from(2) - b.zero) - sx * (from(0) - middle_x) - sy * (from(1) - middle_y);
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
    const auto [from, to] = four_by_two(c.x, c.y);
    const Vec least{from[0], from[1], heights_of(c, 0, 0)}, right{to[0], from[1], heights_of(c, 1, 0)},
        up{from[0], to[1], heights_of(c, 0, 1)}, greatest{to[0], to[1], heights_of(c, 1, 1)};
    const Vec along{splat(direction[0]), splat(direction[1]), splat(direction[2])};
    const F32x8 heights = least.z + right.z + up.z + greatest.z;
    const I32x8 there = heights == heights; // no hole
    const auto square = [](F32x8 v) { return v * v; };
    const F32x8 size2 = max(square(from[0]), square(to[0])) + max(square(from[1]), square(to[1])) +
                        max(max(square(least.z), square(right.z)), max(square(up.z), square(greatest.z)));
    const F32x8 limit = 4 * sqrt(size2) * error + 0x1p-17f * size2 + 1e-36f;
    const F32x8 low = area(along, least, right), far = area(along, right, greatest), high = area(along, greatest, up),
                near = area(along, up, least), rise = area(along, greatest, least), fall = area(along, right, up);
    const I32x8 falls = falling(c);
    CellHits found;
    found.even = hits(low, falls ? fall : far, falls ? near : rise, limit, there);
    found.odd = hits(high, falls ? far : near, falls ? -fall : -rise, limit, there);
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
