// Compiled once per instruction set; see oncollide_add_kernel.
//
// Guigue and Devillers' test for triangle_contact's generic case, one pair per lane. A pair with an uncertain sign is
// left to the scalar test, unless another sign shows that it is separate.
#include <oncollide/narrowphase/exact/kernels/triangle_lanes.hpp>

namespace oncollide::ONCOLLIDE_ISA {
namespace {

/// Error bound of each component of an axis: 2^-50 times the product of two sides.
inline F64 axis_error(const Corners& a, const Corners& b)
{
    const auto [x, y, z] = sides(a, b);
    return (x * y + y * z + z * x) * 0x1p-49;
}

/// Squared lower bounds of distances, one per lane, from axes that separate the triangles.
struct Gaps {
    F64 bound, length_error2;
    F64 height = F64{}, length2 = F64{} + 1;

    Gaps(const Corners& a, const Corners& b, F64 bound_of_determinants) : bound(bound_of_determinants)
    {
        const F64 error = axis_error(a, b);
        length_error2 = error * error * 1040 + 0x1p-960; // 0x1p-960 is more than the underflow of squares
    }
    /// Lanes that the axis separates: the gap is the determinant over the length of the axis.
    void take(I64 where, F64 determinant, const Vec& axis)
    {
        height = where ? determinant - bound : height, length2 = where ? dot(axis, axis) : length2;
    }
    /// (l + e)^2 <= (1 + 2^-10) l^2 + (1 + 2^10) e^2; roundings are far below that.
    F64 squared() const { return height * height / (length2 * (1 + 0x1p-9) + length_error2); }
};
struct NoGaps {
    void take(I64, F64, const Vec&) {}
};

/// Lanes that are certainly separate, and lanes in which nothing is uncertain.
struct Verdicts {
    I64 separate, known;
};

template <class Gaps>
inline Verdicts judge(Corners a, Corners b, F64 bound, Gaps& gaps)
{
    const Sides of_b(b, a, bound);
    I64 separate = of_b.apart();
    gaps.take(separate, of_b.beyond(), of_b.normal);
    if (bits(~separate) == 0) return {separate, separate};
    const Sides of_a(a, b, bound);
    gaps.take(of_a.apart() & ~separate, of_a.beyond(), of_a.normal);
    separate |= of_a.apart();
    if (bits(~separate) == 0) return {separate, separate};
    const I64 known = of_a.known() & of_b.known() & ~separate;

    // As in triangle_contact: the edges that leave the lone corners, in the order that the corners' sides require.
    const Turn turn_a(of_a), turn_b(of_b);
    turn_a(a.p, a.q, a.r), turn_b(b.p, b.q, b.r);
    const I64 b_above = turn_b.above, alike = ~(turn_a.above ^ b_above);
    const Vec w = b.p - a.p, t = b.q - b.p, u = b.r - b.p;
    const Vec first_axis = cross(a.q - a.p, select(alike, t, u)), second_axis = cross(a.r - a.p, select(alike, u, t));
    const F64 first = dot(first_axis, w), second = dot(second_axis, w);
    const I64 first_above = first > bound, first_below = first < -bound;
    const I64 second_above = second > bound, second_below = second < -bound;
    const I64 by_first = known & ((b_above & first_below) | (~b_above & first_above));
    const I64 by_second = known & ((b_above & second_above) | (~b_above & second_below));
    // If their intervals on the line of the planes do not meet, an axis orthogonal to the two edges separates the
    // triangles.
    gaps.take(by_first, max(first, -first), first_axis);
    gaps.take(by_second, max(second, -second), second_axis);
    separate |= by_first | by_second;
    return {separate, separate | (known & (first_above | first_below) & (second_above | second_below))};
}

/// One pair of triangles per lane. Keeps the least gaps, and leaves pairs whose squared gaps underflow or overflow to
/// exact arithmetic.
inline Verdicts judge_with_gaps(const Corners& a, const Corners& b, F64 bound, double* nearest2)
{
    Gaps gaps(a, b, bound);
    const Verdicts verdicts = judge(a, b, bound, gaps);
    const F64 squared = gaps.squared();
    const I64 none = verdicts.separate & ~((squared > F64{}) & (squared < F64{} + __builtin_inf()));
    const I64 separate = verdicts.separate & ~none;
    F64 least;
    __builtin_memcpy(&least, nearest2, sizeof least);
    least = separate ? min(squared, least) : least;
    __builtin_memcpy(nearest2, &least, sizeof least);
    return {separate, verdicts.known & ~none};
}

PairVerdicts judge_all(const CornersOfPairs& corners, const double* rotation, const double* translation,
                       double (*nearest2)[8])
{
    PairVerdicts all{0, 0};
    for (unsigned first = 0; first < 8; first += width) {
        const auto [a, b] = corners_of(corners, first, rotation, translation);
        const F64 bound = error_bound(a, b);
        NoGaps none;
        const Verdicts verdicts = nearest2 ? judge_with_gaps(a, b, bound, *nearest2 + first) : judge(a, b, bound, none);
        all.separate |= bits(verdicts.separate) << first, all.known |= bits(verdicts.known) << first;
    }
    return all;
}

} // namespace

JudgePairs* judge_pairs()
{
    return judge_all;
}

} // namespace oncollide::ONCOLLIDE_ISA
