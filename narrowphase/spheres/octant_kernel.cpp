// Compiled once per instruction set; see oncollide_add_kernel.
//
// Source of the test: Akenine-Möller, "Fast 3D triangle-box overlap testing", JGT 2001; here against eight boxes at
// once, lane k being octant k.
//
// Why no octant is missed: with M the root's largest half-extent, every float below has magnitude at most 4 M, and the
// test grows octants by slack = 2^-18 M on each axis.
// - Float copies of the vertices and the cell's centre err by 2^-23 M each.
// - Edge axis a = u_k x e: its components come from e without further rounding, so both sides of the comparison err by
//   at most 24 * 2^-24 |a|_1 M. This is less than slack |a|_1, which the growth of the octant adds.
// - Face axis: the unit normal errs by 2^-24 per component, the comparison by 12 * 2^-24 M, less than slack.
#include <oncollide/base/simd/simd.hpp>
#include <oncollide/narrowphase/spheres/octant_kernel.hpp>

namespace oncollide::ONCOLLIDE_ISA {
namespace {

using F32x4 = float __attribute__((vector_size(16)));

inline unsigned bits3(int __attribute__((vector_size(16))) mask)
{
#if defined(__SSE2__)
    return static_cast<unsigned>(_mm_movemask_ps(reinterpret_cast<__m128>(mask))) & 7;
#else
    return static_cast<unsigned>((mask[0] & 1) | (mask[1] & 2) | (mask[2] & 4));
#endif
}

/// Octants that overlap on all three axes: bits of the low halves and of the high halves, one bit per axis.
inline unsigned octants(unsigned low, unsigned high)
{
    const auto axis = [&](unsigned a, unsigned low_octants, unsigned high_octants) {
        return (low >> a & 1 ? low_octants : 0u) | (high >> a & 1 ? high_octants : 0u);
    };
    return axis(0, 0x55, 0xaa) & axis(1, 0x33, 0xcc) & axis(2, 0x0f, 0xf0);
}

struct Lanes {
    F32x8 x, y, z;    ///< octants' centres relative to the cell's
    float qx, qy, qz; ///< octants' half-extents, grown by slack
};

inline float abs(float v)
{
    return v < 0 ? -v : v;
}

/// Lanes whose octant is separated by an axis. The triangle's projection is [p, q] or [q, p], the octants' centres
/// project to `shift`, and their radius is `r`.
inline I32x8 apart(float p, float q, F32x8 shift, float r)
{
    const float lo = p < q ? p : q, hi = p < q ? q : p;
    return ((lo - shift) > splat(r)) | ((hi - shift) < splat(-r));
}

inline unsigned separated(const F32x4 v[3], const Lanes& o)
{
    const float nx = v[0][3], ny = v[1][3], nz = v[2][3];
    const float n0 = nx * v[0][0] + ny * v[0][1] + nz * v[0][2];
    I32x8 out = apart(n0, n0, nx * o.x + ny * o.y + nz * o.z, abs(nx) * o.qx + abs(ny) * o.qy + abs(nz) * o.qz);
    for (int i = 0; i < 3; ++i) {
        const F32x4 p = v[i], q = v[(i + 1) % 3], c = v[(i + 2) % 3], e = q - p;
        const float ex = e[0], ey = e[1], ez = e[2], fx = abs(ex), fy = abs(ey), fz = abs(ez);
        out |= apart(ey * p[2] - ez * p[1], ey * c[2] - ez * c[1], ey * o.z - ez * o.y, fy * o.qz + fz * o.qy);
        out |= apart(ez * p[0] - ex * p[2], ez * c[0] - ex * c[2], ez * o.x - ex * o.z, fz * o.qx + fx * o.qz);
        out |= apart(ex * p[1] - ey * p[0], ex * c[1] - ey * c[0], ex * o.y - ey * o.x, fx * o.qy + fy * o.qx);
    }
    return bits(out);
}

std::uint32_t octant_test_kernel(const Primitive* primitives, bool boxes, const TriangleSpan& triangles,
                                 const OctantCell& cell, std::uint32_t* ids, std::uint8_t* masks)
{
    const float s = cell.slack;
    const F32x4 centre{cell.centre[0], cell.centre[1], cell.centre[2], 0};
    const F32x4 outer{cell.half[0] + s, cell.half[1] + s, cell.half[2] + s, 0};
    const F32x4 inner{s, s, s, 0};
    const F32x8 sx{-1, 1, -1, 1, -1, 1, -1, 1}, sy{-1, -1, 1, 1, -1, -1, 1, 1}, sz{-1, -1, -1, -1, 1, 1, 1, 1};
    const float hx = 0.5f * cell.half[0], hy = 0.5f * cell.half[1], hz = 0.5f * cell.half[2];
    const Lanes lanes{sx * hx, sy * hy, sz * hz, hx + s, hy + s, hz + s};

    std::uint32_t found = 0;
    for (std::uint32_t i = 0; i < triangles.count; ++i) {
        if (triangles.ids && !(triangles.masks[i] >> triangles.octant & 1)) continue;
        const std::uint32_t id = triangles.ids ? triangles.ids[i] : i;
        const float(*point)[4] = primitives[id].point;
        const F32x4 v[3] = {*reinterpret_cast<const F32x4*>(point[0]) - centre,
                            *reinterpret_cast<const F32x4*>(point[1]) - centre,
                            *reinterpret_cast<const F32x4*>(point[2]) - centre};
        F32x4 lo = v[0] < v[1] ? v[0] : v[1], hi = v[0] < v[1] ? v[1] : v[0];
        lo = v[2] < lo ? v[2] : lo, hi = v[2] > hi ? v[2] : hi;
        const unsigned in_low = bits3((lo <= inner) & (hi >= -outer)), in_high = bits3((hi >= -inner) & (lo <= outer));
        unsigned mask = octants(in_low, in_high);
        if (!mask) continue;
        const bool one_octant = (mask & (mask - 1)) == 0;
        const bool whole = bits3((lo >= -outer) & (hi <= outer)) == 7;
        if (!boxes && !(one_octant && whole)) mask &= ~separated(v, lanes);
        if (!mask) continue;
        ids[found] = id;
        masks[found++] = static_cast<std::uint8_t>(mask);
    }
    return found;
}

} // namespace

OctantTest* octant_test()
{
    return octant_test_kernel;
}

} // namespace oncollide::ONCOLLIDE_ISA
