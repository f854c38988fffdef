#pragma once
// Part of oriented_box_kernel.cpp: how the boxes of nodes, of triangles and of cells are opened, eight at a time.
#include <oncollide/base/simd/simd_vectors.hpp>
#include <oncollide/narrowphase/obb/oriented_box_kernel.hpp>

namespace oncollide::ONCOLLIDE_ISA {
namespace {

inline Vec rotated(const float (&m)[9], const Vec& v)
{
    return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[3] * v.x + m[4] * v.y + m[5] * v.z,
            m[6] * v.x + m[7] * v.y + m[8] * v.z};
}
/// Any direction of length 1 orthogonal to u.
inline Vec normal_to(const Vec& u)
{
    const F32x8 one = splat(1), none = splat(0);
    const I32x8 x_least = (abs(u.x) <= abs(u.y)) & (abs(u.x) <= abs(u.z)), y_less = abs(u.y) <= abs(u.z);
    const Vec v = cross(u, choose(x_least, {one, none, none}, choose(y_less, {none, one, none}, {none, none, one})));
    return scaled(v, 1 / sqrt(dot(v, v)));
}
inline void store(float (&to)[3][8], const Vec& v)
{
    store(to[0], v.x), store(to[1], v.y), store(to[2], v.z);
}

constexpr float far_away = 1e30f;

/// Stores boxes whose centres are relative to the placement's `from`, after moving them.
[[gnu::always_inline]] inline void put(Vec centre, Vec (&axes)[3], unsigned lanes, const BoxPlacement* placement,
                                       OpenBoxes& out)
{
    if (placement && placement->rotated) {
        centre = rotated(placement->rotation, centre);
        centre = {centre.x + placement->translation[0], centre.y + placement->translation[1],
                  centre.z + placement->translation[2]};
#pragma GCC unroll 3
        for (Vec& axis : axes) axis = rotated(placement->rotation, axis);
    }
    centre.x = I32x8{0, 1, 2, 3, 4, 5, 6, 7} < static_cast<int>(lanes) ? centre.x : splat(far_away);
    store(out.c, centre);
#pragma GCC unroll 3
    for (int i = 0; i < 3; ++i) store(out.axis[i], axes[i]);
}

/// The axes of a node's boxes, as axes_of() in oriented_box.cpp, operation by operation.
[[gnu::always_inline]] inline void read_axes(const BoxNode& node, Vec (&axes)[3])
{
    F32x8 w = widen(node.qw) * (1.0f / 32767), x = widen(node.qx) * (1.0f / 32767), y = widen(node.qy) * (1.0f / 32767),
          z = widen(node.qz) * (1.0f / 32767);
    const F32x8 stretch = 1.5f - 0.5f * (w * w + x * x + y * y + z * z);
    w = w * stretch, x = x * stretch, y = y * stretch, z = z * stretch;
    const F32x8 x2 = x + x, y2 = y + y, z2 = z + z;
    const F32x8 xx = x * x2, yy = y * y2, zz = z * z2, xy = x * y2, xz = x * z2, yz = y * z2, wx = w * x2, wy = w * y2,
                wz = w * z2;
    axes[0] = {1 - (yy + zz), xy + wz, xz - wy};
    axes[1] = {xy - wz, 1 - (xx + zz), yz + wx};
    axes[2] = {xz + wy, yz - wx, 1 - (xx + yy)};
}

/// A centre and half-extents are below 77,600 units, so this is at least 432 * 2^-24 of their sum.
inline float margin_of(const BoxNode& node)
{
    return 2 * node.unit;
}

void open(const BoxNode& node, const BoxPlacement* placement, OpenBoxes& out)
{
    const F32x8 unit = splat(node.unit);
    float origin[3] = {node.origin[0], node.origin[1], node.origin[2]};
    if (placement)
        for (int i = 0; i < 3; ++i) origin[i] -= placement->from[i];
    Vec centre{origin[0] + widen(node.x) * unit, origin[1] + widen(node.y) * unit, origin[2] + widen(node.z) * unit};
    Vec axes[3];
    read_axes(node, axes);
    put(centre, axes, node.lanes, placement, out);
    const Vec half{widen(node.hx) * unit, widen(node.hy) * unit, widen(node.hz) * unit};
    store(out.h, half);
    store(out.size, half.x * half.x + half.y * half.y + half.z * half.z);
    out.margin = margin_of(node);
}

inline float greatest(F32x8 v)
{
    float lanes[8], most = 0;
    store(lanes, v);
    for (const float lane : lanes) most = lane > most ? lane : most;
    return most;
}

/// The first axis is along the longest side or, of a right-angled triangle, along a leg: the box of half a rectangle is
/// then this rectangle. The last axis is along the normal.
void open_triangles(const TriangleRow& row, const BoxPlacement* placement, OpenBoxes& out)
{
    const Vec s = load(row.sides[0]), t = load(row.sides[1]), r{t.x - s.x, t.y - s.y, t.z - s.z};
    const F32x8 ss = dot(s, s), tt = dot(t, t), rr = dot(r, r), longest2 = max(ss, max(tt, rr));
    const F32x8 middle2 = max(min(ss, tt), min(max(ss, tt), rr));
    const F32x8 side2 = abs(ss + tt + rr - 2 * longest2) < 0.001f * longest2 ? middle2 : longest2;
    // A triangle with sides below 2^-20 is a point: the box is along the mesh's axes, and still holds the three
    // corners.
    const I32x8 point = longest2 < splat(0x1p-40f);
    const Vec side = choose(ss == side2, s, choose(tt == side2, t, r));
    const Vec u = choose(point, {splat(1), splat(0), splat(0)}, scaled(side, 1 / sqrt(point ? splat(1) : side2)));
    Vec n = cross(s, t);
    const F32x8 area2 = dot(n, n);
    const I32x8 thin = (area2 < 0x1p-32f * longest2 * longest2) | point;
    n = scaled(n, 1 / sqrt(thin ? splat(1) : area2));
    if (bits(thin)) n = choose(thin, normal_to(u), n);
    // The normal of a sliver is not quite orthogonal to its side, so v is a little short.
    Vec v = cross(n, u);
    v = scaled(v, 1.5f - 0.5f * dot(v, v));
    Vec axes[3] = {u, v, cross(u, v)};
    const F32x8 none = splat(0);
    Vec centre{none, none, none};
    F32x8 half[3], all = none;
#pragma GCC unroll 3
    for (int i = 0; i < 3; ++i) {
        const F32x8 to_s = dot(axes[i], s), to_t = dot(axes[i], t);
        const F32x8 low = min(min(to_s, to_t), none), high = max(max(to_s, to_t), none);
        const F32x8 middle = 0.5f * row.size * (low + high);
        centre = {centre.x + middle * axes[i].x, centre.y + middle * axes[i].y, centre.z + middle * axes[i].z};
        half[i] = 0.5f * row.size * (high - low) + 0x1p-20f * row.size; // 0x1p-20 of the size exceeds the rounding
                                                                        // error
        all = all + half[i];
    }
    centre = {load(row.corner[0]) + centre.x, load(row.corner[1]) + centre.y, load(row.corner[2]) + centre.z};
    put(centre, axes, row.lanes, placement, out);
    const Vec halves{half[0], half[1], half[2]};
    store(out.h, halves);
    store(out.size, dot(halves, halves));
    out.margin = 2 * box_margin * greatest(all);
}

void open_octants(const OctantBoxes& row, unsigned lanes, const BoxPlacement* placement, OpenBoxes& out)
{
    constexpr I32x8 lane{0, 1, 2, 3, 4, 5, 6, 7};
    const auto chosen = [&](const float(&of)[3][2]) -> Vec {
        return {(lane & 1) != 0 ? splat(of[0][1]) : splat(of[0][0]),
                (lane & 2) != 0 ? splat(of[1][1]) : splat(of[1][0]),
                (lane & 4) != 0 ? splat(of[2][1]) : splat(of[2][0])};
    };
    Vec centre = chosen(row.centre);
    const Vec half = chosen(row.half);
    if (placement && placement->rotated) {
        centre = rotated(placement->rotation, centre);
        centre = {centre.x + placement->translation[0], centre.y + placement->translation[1],
                  centre.z + placement->translation[2]};
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) store(out.axis[i][j], splat(placement->rotation[3 * j + i]));
    } else {
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) store(out.axis[i][j], splat(i == j ? 1.0f : 0.0f));
    }
    constexpr I32x8 bit{1, 2, 4, 8, 16, 32, 64, 128};
    centre.x = (bit & static_cast<std::int32_t>(lanes)) != 0 ? centre.x : splat(far_away);
    store(out.c, centre);
    store(out.h, half);
    store(out.size, half.x * half.x + half.y * half.y + half.z * half.z);
    out.margin = 0;
    for (int i = 0; i < 3; ++i)
        out.margin += box_margin * (row.half[i][0] > row.half[i][1] ? row.half[i][0] : row.half[i][1]);
}

} // namespace
} // namespace oncollide::ONCOLLIDE_ISA
