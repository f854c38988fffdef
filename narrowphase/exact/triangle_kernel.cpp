// Compiled once per instruction set; see oncollide_add_kernel.
//
// Guigue and Devillers' test for triangle_contact's generic case, a lane a pair. A pair with a sign that is not certain
// is left to the scalar test, unless another sign shows that it is separate.
//
// When a sign is certain. Let X, Y, Z be the sides of the pair's common box, each plus 2^-300. A determinant has six
// terms, each the product of a difference in x, one in y and one in z, so with u = 2^-53 the bound of
// exact_predicates.hpp, 8 u (1 + 8 u) P, has P <= 6 X Y Z; rounding of the sides and of their product included, 56 u X
// Y Z bounds the error. Products of two that underflow, times the third side, err by at most 2^-1072 X, and so on: the
// 2^-300 in the others cover that. Sides above 2^300 might overflow; there the bound is infinite.
#include <oncollide/narrowphase/exact/triangle_lanes.hpp>

namespace oncollide::ONCOLLIDE_ISA {
namespace {

/// Of the box of both, made a little larger.
inline Vec sides(const Corners& a, const Corners& b)
{
    const Vec lo = min(min(min(a.p, a.q), a.r), min(min(b.p, b.q), b.r));
    const Vec hi = max(max(max(a.p, a.q), a.r), max(max(b.p, b.q), b.r));
    const Vec side = hi - lo;
    return {side.x + 0x1p-300, side.y + 0x1p-300, side.z + 0x1p-300};
}

inline F64 error_bound(const Corners& a, const Corners& b)
{
    const auto [x, y, z] = sides(a, b);
    const F64 bound = x * y * z * (56 * 0x1p-53);
    return max(max(x, y), z) < 0x1p300 ? bound : F64{} + __builtin_inf();
}

/// By how much each component of an axis errs at most: 2^-50 times the product of two sides.
inline F64 axis_error(const Corners& a, const Corners& b)
{
    const auto [x, y, z] = sides(a, b);
    return (x * y + y * z + z * x) * 0x1p-49;
}

/// Squared lower bounds on distances, lane by lane, of axes that part the triangles.
struct Gaps {
    F64 bound, length_error2;
    F64 height = F64{}, length2 = F64{} + 1;

    Gaps(const Corners& a, const Corners& b, F64 bound_of_determinants) : bound(bound_of_determinants)
    {
        const F64 error = axis_error(a, b);
        length_error2 = error * error * 1040 + 0x1p-960; // more than what underflows in squares
    }
    /// Where the axis parts them: by the determinant over the length of the axis.
    void take(I64 where, F64 determinant, const Vec& axis)
    {
        height = where ? determinant - bound : height, length2 = where ? dot(axis, axis) : length2;
    }
    /// (l + e)^2 <= (1 + 2^-10) l^2 + (1 + 2^10) e^2; roundings are far below that.
    F64 squared() const { return height * height / (length2 * (1 + 0x1p-9) + length_error2); }
};

/// Of a triangle's corners against a plane: lanes in which p, q, r are certainly above, or below.
struct Sides {
    I64 p_above, q_above, r_above, p_below, q_below, r_below;
    Vec normal;
    F64 beyond; ///< the least of them, where all are on one side, times the normal's length

    Sides(const Corners& corners, const Corners& plane, F64 bound)
    {
        normal = cross(plane.q - plane.p, plane.r - plane.p);
        const F64 p = dot(normal, corners.p - plane.p), q = dot(normal, corners.q - plane.p),
                  r = dot(normal, corners.r - plane.p);
        p_above = p > bound, q_above = q > bound, r_above = r > bound;
        p_below = p < -bound, q_below = q < -bound, r_below = r < -bound;
        beyond = max(min(min(p, q), r), -max(max(p, q), r));
    }
    I64 apart() const { return (p_above & q_above & r_above) | (p_below & q_below & r_below); }
    I64 known() const { return (p_above | p_below) & (q_above | q_below) & (r_above | r_below); }
};

/// Turns the triangle so that p is alone on its side; sets where p is above. For lanes whose sides are known.
inline I64 rotation(Corners& t, const Sides& s)
{
    const I64 r_alone = ~(s.p_above ^ s.q_above), q_alone = ~(s.p_above ^ s.r_above) & ~r_alone;
    const Corners old = t;
    t.p = select(r_alone, old.r, select(q_alone, old.q, old.p));
    t.q = select(r_alone, old.p, select(q_alone, old.r, old.q));
    t.r = select(r_alone, old.q, select(q_alone, old.p, old.r));
    return (r_alone & s.r_above) | (q_alone & s.q_above) | (~(r_alone | q_alone) & s.p_above);
}

/// Lanes that are certainly separate, and lanes about which nothing is uncertain.
struct Verdicts {
    I64 separate, known;
};

inline Verdicts judge(Corners a, Corners b, F64 bound, Gaps& gaps)
{
    const Sides of_b(b, a, bound);
    I64 separate = of_b.apart();
    gaps.take(separate, of_b.beyond, of_b.normal);
    if (bits(~separate) == 0) return {separate, separate};
    const Sides of_a(a, b, bound);
    gaps.take(of_a.apart() & ~separate, of_a.beyond, of_a.normal);
    separate |= of_a.apart();
    if (bits(~separate) == 0) return {separate, separate};
    const I64 known = of_a.known() & of_b.known() & ~separate;

    // As in triangle_contact: the edges that leave the lone corners, in the order that the sides of these call for.
    const I64 a_above = rotation(a, of_a), b_above = rotation(b, of_b), alike = ~(a_above ^ b_above);
    const Vec w = b.p - a.p, t = b.q - b.p, u = b.r - b.p;
    const Vec first_axis = cross(a.q - a.p, select(alike, t, u)), second_axis = cross(a.r - a.p, select(alike, u, t));
    const F64 first = dot(first_axis, w), second = dot(second_axis, w);
    const I64 first_above = first > bound, first_below = first < -bound;
    const I64 second_above = second > bound, second_below = second < -bound;
    const I64 by_first = known & ((b_above & first_below) | (~b_above & first_above));
    const I64 by_second = known & ((b_above & second_above) | (~b_above & second_below));
    // Where their intervals on the line of the planes do not meet, an axis square to the two edges parts the triangles.
    gaps.take(by_first, max(first, -first), first_axis);
    gaps.take(by_second, max(second, -second), second_axis);
    separate |= by_first | by_second;
    return {separate, separate | (known & (first_above | first_below) & (second_above | second_below))};
}

PairVerdicts judge_all(const CornersOfPairs& corners, const double* rotation, const double* translation,
                       double (&nearest2)[8])
{
    PairVerdicts all{0, 0};
    for (unsigned first = 0; first < 8; first += width) {
        const auto [a, b] = corners_of(corners, first, rotation, translation);
        const F64 bound = error_bound(a, b);
        Gaps gaps(a, b, bound);
        const Verdicts verdicts = judge(a, b, bound, gaps);
        const F64 squared = gaps.squared();
        // A gap too small or too large for squares is left to exact arithmetic.
        const I64 none = verdicts.separate & ~((squared > F64{}) & (squared < F64{} + __builtin_inf()));
        const I64 separate = verdicts.separate & ~none;
        F64 least;
        __builtin_memcpy(&least, nearest2 + first, sizeof least);
        least = separate ? min(squared, least) : least;
        __builtin_memcpy(nearest2 + first, &least, sizeof least);
        all.separate |= bits(separate) << first, all.known |= bits(verdicts.known & ~none) << first;
    }
    return all;
}

} // namespace

JudgePairs* judge_pairs()
{
    return judge_all;
}

} // namespace oncollide::ONCOLLIDE_ISA
