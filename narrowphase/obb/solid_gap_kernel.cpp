// Compiled once per instruction set; see oncollide_add_kernel.
#include <oncollide/base/simd/simd.hpp>
#include <oncollide/narrowphase/obb/terrain_lanes.hpp>

namespace oncollide::ONCOLLIDE_ISA {
namespace {

struct Vec {
    F32x8 x, y, z;
};
inline Vec operator-(const Vec& a, const Vec& b)
{
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline F32x8 dot(const Vec& a, const Vec& b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline F32x8 along(const float (&d)[3], const Vec& v)
{
    return d[0] * v.x + d[1] * v.y + d[2] * v.z;
}
inline Vec scaled(F32x8 s, const Vec& v)
{
    return {s * v.x, s * v.y, s * v.z};
}
inline F32x8 choose(I32x8 mask, F32x8 a, F32x8 b)
{
    return mask ? a : b;
}
inline Vec choose(I32x8 mask, const Vec& a, const Vec& b)
{
    return {choose(mask, a.x, b.x), choose(mask, a.y, b.y), choose(mask, a.z, b.z)};
}

constexpr float far_away = 1e30f;

inline F32x8 per(F32x8 length)
{
    return 1 / (length > splat(0) ? length : splat(1));
}

/// The solid's extent along u, of length 1.
inline F32x8 reach(const SolidReach& solid, const Vec& u)
{
    F32x8 sum = splat(solid.radius), squares = splat(0);
#pragma GCC unroll 3
    for (int i = 0; i < 3; ++i) {
        const F32x8 w = along(solid.axis[i], u), round = solid.disc[i] * w;
        sum = sum + solid.half[i] * abs(w), squares = squares + round * round;
    }
    return sum + sqrt(squares);
}

inline unsigned cut(F32x8 gap, float gap_limit, float (&gaps)[8], float (&nearest)[8])
{
    gap = max(gap, splat(-1e30f)); // NaN proves nothing
    const I32x8 near = gap <= splat(gap_limit);
    const F32x8 before = load(nearest);
    store(gaps, gap);
    store(nearest, near ? before : min(before, gap));
    return bits(near);
}

unsigned of_boxes(const OpenBoxes& boxes, const SolidReach& solid, const BoxLine& line, float gap_limit,
                  float (&gaps)[8], float (&nearest)[8])
{
    const Vec c{load(boxes.c[0]), load(boxes.c[1]), load(boxes.c[2])};
    const Vec d{c.x - solid.centre[0], c.y - solid.centre[1], c.z - solid.centre[2]};
    Vec out{splat(0), splat(0), splat(0)}; // vector from the solid's centre to the box
    F32x8 length2 = splat(0), least = along(line.direction, c);
#pragma GCC unroll 3
    for (int i = 0; i < 3; ++i) {
        const Vec axis{load(boxes.axis[i][0]), load(boxes.axis[i][1]), load(boxes.axis[i][2])};
        const F32x8 h = load(boxes.h[i]), e = dot(axis, d), beyond = max(abs(e) - h, splat(0)),
                    part = e < splat(0) ? -beyond : beyond;
        out = {out.x + part * axis.x, out.y + part * axis.y, out.z + part * axis.z};
        length2 = length2 + beyond * beyond;
        least = least - h * abs(along(line.direction, axis));
    }
    const F32x8 length = sqrt(length2);
    const F32x8 gap = max(length - reach(solid, scaled(per(length), out)), least - line.other_reach);
    return cut(gap - boxes.margin, gap_limit, gaps, nearest);
}

inline F32x8 between(F32x8 low, F32x8 v, F32x8 high)
{
    return min(max(v, low), high);
}

/// The gap along the direction of the point half-way between the planes that is nearest to the solid's centre.
inline F32x8 slab_gap(const TerrainBlocks& blocks, const F32x8 (&from)[3], const F32x8 (&to)[3],
                      const SolidReach& solid)
{
    const F32x8 sx = load(blocks.slope_x), sy = load(blocks.slope_y), low = load(blocks.slab_low),
                high = load(blocks.slab_high);
    const F32x8 hx = 0.5f * (to[0] - from[0]), hy = 0.5f * (to[1] - from[1]), thick = 0.5f * (high - low);
    // Offset from the point where the heights of the planes are given.
    F32x8 dx = hx - blocks.half_x, dy = hy - blocks.half_y;
    if (blocks.one_slope) {
        dx = dx + blocks.half_x * F32x8{-1, 1, -1, 1, -1, 1, -1, 1};
        dy = dy + blocks.half_y * F32x8{-3, -3, -1, -1, 1, 1, 3, 3};
    }
    const Vec m{0.5f * (from[0] + to[0]) - solid.centre[0], 0.5f * (from[1] + to[1]) - solid.centre[1],
                (blocks.zero - solid.centre[2]) + (0.5f * (low + high) + sx * dx + sy * dy)};
    const F32x8 z = m.z - sx * m.x - sy * m.y, xx = 1 + sx * sx, yy = 1 + sy * sy;
    F32x8 px = between(m.x - hx, -sx * z / (xx + sy * sy), m.x + hx);
    const F32x8 py = between(m.y - hy, -sy * (z + sx * px) / yy, m.y + hy);
    px = between(m.x - hx, -sx * (z + sy * py) / xx, m.x + hx);
    const Vec p{px, py, z + sx * px + sy * py}, u = scaled(per(sqrt(dot(p, p))), p);
    const F32x8 least = dot(u, m) - hx * abs(u.x + u.z * sx) - hy * abs(u.y + u.z * sy) - thick * abs(u.z);
    const F32x8 steps = abs(sx) * (hx + abs(dx)) + abs(sy) * (hy + abs(dy)) + thick;
    return least - reach(solid, u) - box_margin * steps - blocks.margin;
}

unsigned of_blocks(const TerrainBlocks& blocks, const SolidReach& solid, const BoxLine& line, float gap_limit,
                   float (&gaps)[8], float (&nearest)[8])
{
    const TerrainLanes lanes = lanes_of(blocks);
    const F32x8 from[3] = {lanes.from[0], lanes.from[1], blocks.zero + load(blocks.low)},
                to[3] = {lanes.to[0], lanes.to[1], blocks.zero + load(blocks.high)};
    F32x8 out[3], least = splat(-line.other_reach);
#pragma GCC unroll 3
    for (int i = 0; i < 3; ++i) {
        out[i] = max(from[i] - solid.centre[i], splat(0)) + min(to[i] - solid.centre[i], splat(0));
        least = least + min(line.direction[i] * from[i], line.direction[i] * to[i]);
    }
    const Vec v{out[0], out[1], out[2]};
    const F32x8 length = sqrt(dot(v, v));
    const F32x8 gap = max(length - reach(solid, scaled(per(length), v)), least);

    const I32x8 there = (from[0] < to[0]) & (from[1] < to[1]) & (from[2] <= to[2]);
    const F32x8 near = there ? gap - box_margin * (to[2] - from[2]) - blocks.margin : splat(far_away);
    if (!bits(near <= splat(gap_limit))) return cut(near, gap_limit, gaps, nearest);
    return cut(max(slab_gap(blocks, from, to, solid), near), gap_limit, gaps, nearest);
}

/// The gap of the triangle p, p + u, p + v from the solid, whose centre is the origin: along the direction of the
/// triangle's nearest point and along the line. Rounding may change that direction, but the corners' projections onto
/// it always give a lower bound.
/// @param edges2  out: the squared distance of an edge
inline F32x8 triangle_gap(const Vec& p, const Vec& u, const Vec& v, const SolidReach& solid, const BoxLine& line,
                          F32x8& edges2)
{
    const F32x8 uu = dot(u, u), vv = dot(v, v), uv = dot(u, v), pu = -dot(p, u), pv = -dot(p, v);
    const auto at = [&](F32x8 s, F32x8 t) {
        return Vec{p.x + s * u.x + t * v.x, p.y + s * u.y + t * v.y, p.z + s * u.z + t * v.z};
    };
    const auto share = [](F32x8 a, F32x8 b) { return between(splat(0), a / (b > splat(0) ? b : splat(1)), splat(1)); };
    Vec best = at(share(pu, uu), splat(0));
    F32x8 best2 = dot(best, best);
    const auto take = [&](F32x8 s, F32x8 t) {
        const Vec other = at(s, t);
        const F32x8 other2 = dot(other, other);
        best = choose(other2 < best2, other, best), best2 = min(best2, other2);
    };
    take(splat(0), share(pv, vv));
    const F32x8 t = share(pv - pu + uu - uv, uu + vv - 2 * uv);
    take(1 - t, t);
    edges2 = best2;
    const F32x8 s = vv * pu - uv * pv, r = uu * pv - uv * pu, all = uu * vv - uv * uv;
    const I32x8 over = (s > splat(0)) & (r > splat(0)) & (s + r < all);
    best = choose(over, at(s / all, r / all), best);
    const Vec to = scaled(per(sqrt(dot(best, best))), best);
    const auto lowest = [&](F32x8 of_p, F32x8 of_u, F32x8 of_v) { return of_p + min(min(of_u, of_v), splat(0)); };
    const auto& d = line.direction;
    const float centre = d[0] * solid.centre[0] + d[1] * solid.centre[1] + d[2] * solid.centre[2];
    return max(lowest(dot(to, p), dot(to, u), dot(to, v)) - reach(solid, to),
               lowest(along(d, p), along(d, u), along(d, v)) + (centre - line.other_reach));
}

unsigned of_cells(const TerrainCells& cells, const SolidReach& solid, const BoxLine& line, float gap_limit,
                  float (&gaps)[2][8], float (&nearest)[8], float& apart)
{
    const float(&o)[3] = solid.centre;
    const TerrainLanes lanes = four_by_two(cells.x, cells.y);
    const F32x8 west = lanes.from[0] - o[0], east = lanes.to[0] - o[0], south = lanes.from[1] - o[1],
                north = lanes.to[1] - o[1];
    const auto heights = [&](int i, int j) { return heights_of(cells, i, j) - o[2]; };
    const Vec p00{west, south, heights(0, 0)}, p10{east, south, heights(1, 0)}, p01{west, north, heights(0, 1)},
        p11{east, north, heights(1, 1)};
    const F32x8 high = max(max(p00.z, p10.z), max(p01.z, p11.z)), low = min(min(p00.z, p10.z), min(p01.z, p11.z)),
                sum = p00.z + p10.z + p01.z + p11.z;
    const I32x8 falls = falling(cells), there = (sum == sum) & (west < east) & (south < north);
    const Vec corner = choose(falls, p10, p00), across = choose(falls, p01, p11); // ends of the diagonal
    const Vec diagonal = across - corner;
    F32x8 of_even, of_odd;
    const F32x8 even = triangle_gap(corner, diagonal, choose(falls, p00, p10) - corner, solid, line, of_even),
                odd = triangle_gap(corner, diagonal, choose(falls, p11, p01) - corner, solid, line, of_odd);
    const F32x8 margin = cells.margin + box_margin * (high - low);
    float least[8];
    store(least, sqrt(there ? min(of_odd, of_even) : splat(far_away)) + margin);
    for (const float d : least) apart = d < apart ? d : apart;
    const unsigned first = cut(there ? even - margin : splat(far_away), gap_limit, gaps[0], nearest);
    return first | cut(there ? odd - margin : splat(far_away), gap_limit, gaps[1], nearest) << 8;
}

} // namespace

SolidGapKernel solid_gap_kernel()
{
    return {of_boxes, of_blocks, of_cells};
}

} // namespace oncollide::ONCOLLIDE_ISA
