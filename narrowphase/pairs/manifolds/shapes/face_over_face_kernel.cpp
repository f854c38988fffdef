// Compiled once per instruction set; see oncollide_add_kernel.
#include <oncollide/base/simd/simd_doubles.hpp>
#include <oncollide/narrowphase/pairs/manifolds/shapes/face_over_face_kernel.hpp>

namespace oncollide::ONCOLLIDE_ISA {
namespace {

constexpr F64x4 high_u{1, -1, -1, 1}, high_v{1, 1, -1, -1};
/// Share of the rounding. Corners nearer to each other count once.
constexpr double same_place = 0.25;

inline F64x4 all(double v)
{
    return F64x4{v, v, v, v};
}
/// Lane k has lane k - 1.
inline F64x4 before(F64x4 v)
{
    return ONCOLLIDE_SHUFFLE_DOUBLES(v, 3, 0, 1, 2);
}
inline F64x4 within(F64x4 v, F64x4 half)
{
    return min(max(v, -half), half);
}

/// Bit k moves to bit 4 k.
inline unsigned every_fourth(unsigned mask)
{
    return (mask & 1) | (mask & 2) << 3 | (mask & 4) << 6 | (mask & 8) << 9;
}

/// Where lines pass a slab: times of entering and of leaving.
struct Passage {
    F64x4 from, to;
};
inline Passage pass(F64x4 start, F64x4 way, F64x4 half)
{
    const F64x4 least = all(1e-300), inverse = 1 / (abs(way) < least ? least : way);
    const F64x4 low = (-half - start) * inverse, high = (half - start) * inverse;
    return {min(low, high), max(low, high)};
}

void find(const FaceOverFace& f, CommonCorners& found)
{
    const F64x4 half_x = all(f.half_x), half_y = all(f.half_y), rounding = all(f.rounding);
    const F64x4 x = f.middle[0] + high_u * f.u[0] + high_v * f.v[0],
                y = f.middle[1] + high_u * f.u[1] + high_v * f.v[1],
                z = f.middle[2] + high_u * f.u[2] + high_v * f.v[2];
    store(found.x[CommonCorners::of_upper], x), store(found.y[CommonCorners::of_upper], y);
    store(found.z[CommonCorners::of_upper], z);
    const unsigned inside = bits((abs(x) <= half_x + rounding) & (abs(y) <= half_y + rounding));

    // The sides, each from the corner before it.
    const F64x4 from_x = before(x), from_y = before(y), from_z = before(z);
    const F64x4 way_x = x - from_x, way_y = y - from_y, way_z = z - from_z;
    const Passage in_x = pass(from_x, way_x, half_x), in_y = pass(from_y, way_y, half_y);
    const F64x4 from = max(in_x.from, in_y.from), to = min(in_x.to, in_y.to);
    const I64x4 passes = from <= to;
    const unsigned starts_inside = (inside << 1 | inside >> 3) & 15;
    // Stores places. Places at a corner of the rectangle do not count: the parallelogram holds that corner.
    const auto put = [&](CommonCorners::Kind kind, F64x4 t) -> I64x4 {
        const F64x4 at_x = within(from_x + t * way_x, half_x), at_y = within(from_y + t * way_y, half_y);
        store(found.x[kind], at_x), store(found.y[kind], at_y), store(found.z[kind], from_z + t * way_z);
        const F64x4 near = same_place * rounding;
        return (abs(at_x) < half_x - near) | (abs(at_y) < half_y - near);
    };
    const unsigned enters =
                       bits(passes & (from > 0) & (from <= 1) & put(CommonCorners::entering, from)) & ~starts_inside,
                   leaves = bits(passes & (to >= 0) & (to < 1) & put(CommonCorners::leaving, to)) & ~inside;
    found.through_x[CommonCorners::entering] = bits(in_x.from > in_y.from);
    found.through_x[CommonCorners::leaving] = bits(in_x.to < in_y.to);
    found.rises_x = bits(way_x > 0), found.rises_y = bits(way_y > 0);

    // The parallelogram holds corners of the rectangle; a corner at one of its own is there already.
    const F64x4 corner_x = high_u * f.half_x, corner_y = high_v * f.half_y;
    const F64x4 rest_x = corner_x - f.middle[0], rest_y = corner_y - f.middle[1];
    const double inverse = 1 / (f.u[0] * f.v[1] - f.u[1] * f.v[0]),
                 wide = f.rounding * (inverse < 0 ? -inverse : inverse);
    const F64x4 s = (rest_x * f.v[1] - rest_y * f.v[0]) * inverse, t = (rest_y * f.u[0] - rest_x * f.u[1]) * inverse;
    const F64x4 near_s = wide * (abs(all(f.v[0])) + abs(all(f.v[1]))),
                near_t = wide * (abs(all(f.u[0])) + abs(all(f.u[1])));
    const F64x4 over_s = abs(s) - 1, over_t = abs(t) - 1;
    const I64x4 same = (abs(over_s) <= same_place * near_s) & (abs(over_t) <= same_place * near_t);
    const unsigned holds = bits((over_s <= near_s) & (over_t <= near_t) & ~same);
    store(found.x[CommonCorners::of_lower], corner_x), store(found.y[CommonCorners::of_lower], corner_y);
    store(found.z[CommonCorners::of_lower], f.middle[2] + s * f.u[2] + t * f.v[2]);
    found.there =
        every_fourth(enters) | every_fourth(leaves) << 1 | every_fourth(inside) << 2 | every_fourth(holds) << 3;
}

} // namespace

FindCommonCorners* find_common_corners()
{
    return find;
}

} // namespace oncollide::ONCOLLIDE_ISA
