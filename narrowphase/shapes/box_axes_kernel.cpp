// Compiled once per instruction set; see oncollide_add_kernel.
#include <oncollide/base/simd/simd_doubles.hpp>
#include <oncollide/narrowphase/shapes/box_axes_kernel.hpp>

namespace oncollide::ONCOLLIDE_ISA {
namespace {

inline F64x4 load(const double* from)
{
    return F64x4{from[0], from[1], from[2], 0};
}
/// Lane i has lane i + 1, or i + 2, of the first three.
inline F64x4 next(F64x4 v)
{
    return ONCOLLIDE_SHUFFLE_DOUBLES(v, 1, 2, 0, 3);
}
inline F64x4 after_next(F64x4 v)
{
    return ONCOLLIDE_SHUFFLE_DOUBLES(v, 2, 0, 1, 3);
}
/// Infinite where a box has no face across the axis.
inline F64x4 without_face(F64x4 half)
{
    const F64x4 none{__builtin_inf(), __builtin_inf(), __builtin_inf(), __builtin_inf()};
    return (next(half) > 0) & (after_next(half) > 0) & I64x4{-1, -1, -1, 0} ? F64x4{0, 0, 0, 0} : none;
}

void overlap(const TwoBoxes& boxes, double rounding, BoxOverlaps& found)
{
    const F64x4 ha = load(boxes.half_a), hb = load(boxes.half_b), t = load(boxes.between);
    const double* const r = boxes.rotation;
    const F64x4 column[] = {load(r), load(r + 3), load(r + 6)};
    const F64x4 row[] = {{r[0], r[3], r[6], 0}, {r[1], r[4], r[7], 0}, {r[2], r[5], r[8], 0}};
    F64x4 of_a = ha, of_b = hb, along_b = {0, 0, 0, 0}, size[3];
#pragma GCC unroll 3
    for (int k = 0; k < 3; ++k) {
        size[k] = abs(column[k]);
        of_a = of_a + size[k] * boxes.half_b[k], of_b = of_b + abs(row[k]) * boxes.half_a[k];
        along_b = along_b + row[k] * boxes.between[k];
    }
    of_a = of_a - abs(t) + without_face(ha), of_b = of_b - abs(along_b) + without_face(hb);
    store(found.of_a, of_a), store(found.of_b, of_b);
    const F64x4 both = min(of_a, of_b);
    double limit = both[0];
    limit = both[1] < limit ? both[1] : limit, limit = both[2] < limit ? both[2] : limit;
    limit = limit > rounding ? limit - rounding : 0;
    const double limit2 = limit * limit;
    found.open = 0;
#pragma GCC unroll 3
    for (int j = 0; j < 3; ++j) {
        const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
        const F64x4 c1 = next(column[j]), c2 = after_next(column[j]), s1 = next(size[j]), s2 = after_next(size[j]);
        const F64x4 reach =
                        next(ha) * s2 + after_next(ha) * s1 + boxes.half_b[j1] * size[j2] + boxes.half_b[j2] * size[j1],
                    overlap = reach - abs(after_next(t) * c1 - next(t) * c2), length2 = c1 * c1 + c2 * c2;
        store(found.of_edges[j], overlap), store(found.length2[j], length2);
        // Most overlap more, which needs no root. The factor and the term cover the rounding of the length.
        const F64x4 sure = overlap - 2 * rounding;
        found.open |= (bits((sure <= 0) | (sure * sure <= limit2 * (1.001 * length2 + 0x1p-80))) & 7) << 4 * j;
    }
}

} // namespace

OverlapBoxes* overlap_boxes()
{
    return overlap;
}

} // namespace oncollide::ONCOLLIDE_ISA
