// Compiled once per instruction set; see oncollide_add_kernel.
//
// Each of two triangles that cross cuts the line of the two planes in an interval, between the two edges that leave its
// lone corner (the corner alone on its side of the other plane). The common segment is the intersection of the
// intervals: from the later of their beginnings to the earlier of their ends.
//
// An edge pq cuts a plane at t = P / (P - Q), where P and Q are the determinants of its corners, which have different
// signs. If each errs by at most E, then t errs by at most E / (|P - Q| - 2 E). A coordinate errs by that times the
// edge's extent, plus 9 u of the largest coordinate M for rounding: less than 2^-46 M if E times the extent is below
// 2^-47 M |P - Q| and E below 2^-17 |P - Q|.
#include <oncollide/narrowphase/exact/kernels/segment_kernel.hpp>
#include <oncollide/narrowphase/exact/kernels/triangle_lanes.hpp>

namespace oncollide::ONCOLLIDE_ISA {
namespace {

inline F64 largest(const Vec& v)
{
    return max(max(v.x, v.y), v.z);
}
inline Vec abs(const Vec& v)
{
    return {abs(v.x), abs(v.y), abs(v.z)};
}
inline F64 largest_coordinate(const Corners& c)
{
    return largest(max(max(abs(c.p), abs(c.q)), abs(c.r)));
}

/// The sum of magnitudes whose difference cross() takes.
inline Vec cross_magnitude(const Vec& u, const Vec& v)
{
    const auto sum = [](F64 x, F64 y) { return abs(x) + abs(y) + 0x1p-900; };
    return {sum(u.y * v.z, u.z * v.y), sum(u.z * v.x, u.x * v.z), sum(u.x * v.y, u.y * v.x)};
}
inline Vec normal_magnitude(const Corners& plane)
{
    return cross_magnitude(plane.q - plane.p, plane.r - plane.p);
}

/// An edge through a plane: the heights of its corners, and their error bound.
struct Edge {
    Vec p, q;
    F64 p_height, q_height, error;
};
inline Edge select(I64 mask, const Edge& x, const Edge& y)
{
    return {select(mask, x.p, y.p), select(mask, x.q, y.q), select(mask, x.p_height, y.p_height),
            select(mask, x.q_height, y.q_height), select(mask, x.error, y.error)};
}

struct Point {
    Vec at;
    I64 accurate;
};
/// @param size  the largest coordinate
inline Point crossing(const Edge& e, F64 size)
{
    const F64 span = e.p_height - e.q_height, t = e.p_height / span;
    const Vec along = e.q - e.p;
    const I64 accurate = e.error * max(largest(abs(along)), size * 0x1p-30) < abs(span) * size * 0x1p-47;
    return {{e.p.x + t * along.x, e.p.y + t * along.y, e.p.z + t * along.z}, accurate};
}

/// Components err by at most 12 u times magnitude over length, which is at most 2^9, so by 2^-40.
inline Point unit(const Vec& normal, const Vec& magnitude)
{
    const F64 length2 = dot(normal, normal), most = largest(magnitude);
    const F64 shorter = 1 / sqrt(length2);
    const I64 accurate = (most * most < length2 * 0x1p18) & (length2 > 0x1p-800) & (length2 < 0x1p800);
    return {{normal.x * shorter, normal.y * shorter, normal.z * shorter}, accurate};
}

inline void store(const Vec& v, double (&to)[3][8], unsigned first)
{
    __builtin_memcpy(to[0] + first, &v.x, sizeof v.x), __builtin_memcpy(to[1] + first, &v.y, sizeof v.y);
    __builtin_memcpy(to[2] + first, &v.z, sizeof v.z);
}

inline I64 segment(TwoCorners triangles, const RigidMap& place, unsigned first_pair, SegmentsOfPairs& out)
{
    auto& [a, b] = triangles;
    const F64 bound = error_bound(a, b);
    const Vec box = sides(a, b);
    const F64 size = max(largest_coordinate(a), largest_coordinate(b));
    Sides of_a(a, b, bound), of_b(b, a, bound);
    const Vec magnitude_a = normal_magnitude(a), magnitude_b = normal_magnitude(b);
    const auto error_of = [&](const Vec& magnitude) { return dot(magnitude, box) * (10 * 0x1p-53) + 0x1p-900; };
    const F64 error_a = error_of(magnitude_a),
              error_b = error_of(magnitude_b); // error bound of heights above the planes of a, of b
    // Sizes for which nothing below underflows or overflows unnoticed.
    I64 sure = of_a.known() & of_b.known() & ~of_a.apart() & ~of_b.apart() & (size > 0x1p-100) & (size < 0x1p200);

    const Turn turn_a(of_a), turn_b(of_b);
    turn_a(a.p, a.q, a.r), turn_b(b.p, b.q, b.r);
    turn_a(of_a.p, of_a.q, of_a.r), turn_b(of_b.p, of_b.q, of_b.r);
    // The sign of the determinant of an edge of A and an edge of B decides which cuts the line first.
    const Vec w = b.p - a.p, e = a.q - a.p, f = a.r - a.p, tw = cross(b.q - b.p, w), uw = cross(b.r - b.p, w);
    const auto sign = [&](F64 v) { return turn_b.above ? v : -v; };
    const F64 et = sign(dot(e, tw)), ft = sign(dot(f, tw)), eu = sign(dot(e, uw)), fu = sign(dot(f, uw));
    const I64 alike = ~(turn_a.above ^ turn_b.above);
    const Edge pq{a.p, a.q, of_a.p, of_a.q, error_b}, pr{a.p, a.r, of_a.p, of_a.r, error_b};
    const Edge st{b.p, b.q, of_b.p, of_b.q, error_a}, su{b.p, b.r, of_b.p, of_b.r, error_a};
    // A's interval is from pq to pr; B's from su to st if the lone corners are on the same side, else from st to su.
    const F64 begin_to_end = select(alike, et, eu), begins = select(alike, eu, et);
    const F64 end_to_begin = select(alike, fu, ft), ends = select(alike, ft, fu);
    sure &= (begin_to_end > bound) & (end_to_begin < -bound) & (abs(begins) > bound) & (abs(ends) > bound);
    const Point begin = crossing(select(begins > F64{}, select(alike, su, st), pq), size);
    const Point end = crossing(select(ends > F64{}, pr, select(alike, st, su)), size);
    const Point normal_a = unit(of_b.normal, magnitude_a), normal_b = unit(of_a.normal, magnitude_b);

    store(moved(begin.at, place.rotation, place.translation), out.ends[0], first_pair);
    store(moved(end.at, place.rotation, place.translation), out.ends[1], first_pair);
    const double nowhere[3] = {0, 0, 0};
    store(moved(normal_a.at, place.rotation, nowhere), out.normal_a, first_pair);
    store(moved(normal_b.at, place.rotation, nowhere), out.normal_b, first_pair);
    return sure & begin.accurate & end.accurate & normal_a.accurate & normal_b.accurate;
}

unsigned segments_of_all(const CornersOfPairs& corners, const RigidMap& b_to_a, const RigidMap& place,
                         SegmentsOfPairs& out)
{
    unsigned found = 0;
    for (unsigned first = 0; first < 8; first += width)
        found |= bits(segment(corners_of(corners, first, b_to_a.rotation, b_to_a.translation), place, first, out))
                 << first;
    return found;
}

} // namespace

CommonSegments* common_segments()
{
    return segments_of_all;
}

} // namespace oncollide::ONCOLLIDE_ISA
