// Compiled once per instruction set; see oncollide_add_kernel.
//
// The nearest points of two triangles that do not meet are on two edges, or at a corner and on a face. Source: Ericson,
// "Real-Time Collision Detection", 2004, 5.1.5 and 5.1.9; but divisors are squares of cross products: where edges are
// nearly parallel, rounding leaves them twice as many digits as differences of products. An undefined quotient
// (parallel edges, or points) counts as 0.
//
// The points found are points of the triangles, to rounding, so their distance is an upper bound. A slab between the
// triangles shows that no other points are nearer: for any direction, its width is a lower bound of the distance.
// Nearly parallel edges and triangles that are nearly segments may give wrong points, and then no slab is as wide.
#include <oncollide/narrowphase/exact/kernels/triangle_lanes.hpp>

#include <oncollide/narrowphase/exact/kernels/triangle_distance_kernel.hpp>

namespace oncollide::ONCOLLIDE_ISA {
namespace {

inline F64 clamp(F64 v)
{
    return min(max(v, F64{}), F64{} + 1);
}
/// p + s u
inline Vec along(const Vec& p, F64 s, const Vec& u)
{
    return {p.x + s * u.x, p.y + s * u.y, p.z + s * u.z};
}

struct Nearest {
    Vec a{}, b{};
    F64 distance2 = F64{} + __builtin_inf();

    void take(I64 where, const Vec& p, const Vec& q)
    {
        const Vec between = p - q;
        const F64 d2 = dot(between, between);
        const I64 nearer = where & (d2 < distance2);
        a = select(nearer, p, a), b = select(nearer, q, b), distance2 = nearer ? d2 : distance2;
    }
};

struct Edge {
    Vec from, along;
    F64 per_length2;

    Edge(const Vec& p, const Vec& q) : from(p), along(q - p), per_length2(1 / dot(along, along)) {}
};

inline void take_edges(Nearest& nearest, const Edge& a, const Edge& b)
{
    const Vec w = a.from - b.from, n = cross(a.along, b.along);
    const F64 uv = dot(a.along, b.along), uw = dot(a.along, w), vw = dot(b.along, w);
    F64 s = clamp(dot(cross(b.along, w), n) / dot(n, n));
    const F64 t = clamp((vw + uv * s) * b.per_length2);
    s = clamp((uv * t - uw) * a.per_length2);
    nearest.take(~I64{}, along(a.from, s, a.along), along(b.from, t, b.along));
}

/// A triangle, prepared for comparison with corners.
struct Face {
    Vec from, u, v, across_u, across_v; ///< all lie in the triangle's plane, orthogonal to u and to v
    F64 n2, per_n2;

    explicit Face(const Corners& t) : from(t.p), u(t.q - t.p), v(t.r - t.p)
    {
        const Vec n = cross(u, v);
        across_u = cross(n, u), across_v = cross(v, n);
        n2 = dot(n, n), per_n2 = 1 / n2;
    }
    /// Sets q to the projection of p onto the face. False if it is outside the face.
    I64 below(const Vec& p, Vec& q) const
    {
        const Vec w = p - from;
        const F64 s = dot(w, across_v), r = dot(w, across_u);
        q = along(along(from, s * per_n2, u), r * per_n2, v);
        return (s >= 0) & (r >= 0) & (s + r <= n2) & (n2 > 0);
    }
};

inline Nearest nearest_points(const Corners& a, const Corners& b)
{
    Nearest nearest;
    const Edge of_a[3] = {{a.p, a.q}, {a.q, a.r}, {a.r, a.p}}, of_b[3] = {{b.p, b.q}, {b.q, b.r}, {b.r, b.p}};
    for (const Edge& u : of_a)
        for (const Edge& v : of_b) take_edges(nearest, u, v);
    const Face face_a(a), face_b(b);
    Vec below{};
    for (const Edge& v : of_b) {
        const I64 is_below = face_a.below(v.from, below);
        nearest.take(is_below, below, v.from);
    }
    for (const Edge& u : of_a) {
        const I64 is_below = face_b.below(u.from, below);
        nearest.take(is_below, u.from, below);
    }
    return nearest;
}

inline void store(double* to, F64 v)
{
    __builtin_memcpy(to, &v, sizeof v);
}
inline void store(double (&to)[3][8], unsigned first, const Vec& v)
{
    store(to[0] + first, v.x), store(to[1] + first, v.y), store(to[2] + first, v.z);
}

/// Shows lower bounds of the triangles' distances.
///
/// Rounding: let R be the sum of the sides of the box around both triangles. A coordinate of a corner relative to
/// `from` errs by u = 2^-53 of itself, and a projection on the axis, of length l, by 4 u l R. A gap is the difference
/// of two: 2^-49 l R bounds its error.
class Slabs {
public:
    Slabs(const Corners& a, const Corners& b, const Nearest& nearest, F64 distance, double rounding)
        : a_{a.p - nearest.a, a.q - nearest.a, a.r - nearest.a}, b_{b.p - nearest.a, b.q - nearest.a, b.r - nearest.a}
    {
        const auto [x, y, z] = sides(a, b);
        least_ = distance * (1 + 0x1p-50) - rounding;
        shown_ = least_ <= F64{};
        least_ += (x + y + z) * 0x1p-49;
    }
    void take(const Vec& axis)
    {
        const F64 a0 = dot(axis, a_.p), a1 = dot(axis, a_.q), a2 = dot(axis, a_.r);
        const F64 b0 = dot(axis, b_.p), b1 = dot(axis, b_.q), b2 = dot(axis, b_.r);
        const F64 gap = max(min(min(b0, b1), b2) - max(max(a0, a1), a2), min(min(a0, a1), a2) - max(max(b0, b1), b2));
        const F64 length2 = dot(axis, axis);
        // Squares below 2^-900 may have underflowed. Comparisons with NaN and with overflow do not hold.
        shown_ |= (gap > F64{}) & (least_ > 0x1p-450) & (length2 > 0x1p-900) &
                  (gap * gap >= least_ * least_ * length2 * (1 + 0x1p-48)) & (gap * gap < __builtin_inf());
    }
    /// The axes that may part two triangles: normals, across two edges, and from point to point across an edge.
    void take_all(const Nearest& nearest)
    {
        const Vec of_a[3] = {a_.q - a_.p, a_.r - a_.q, a_.p - a_.r}, of_b[3] = {b_.q - b_.p, b_.r - b_.q, b_.p - b_.r};
        const Vec between = nearest.b - nearest.a;
        const auto across = [&](const Vec& edge) {
            // The errors of both points along the edge would tilt the slab over its length.
            const F64 s = dot(between, edge) / dot(edge, edge);
            take({between.x - s * edge.x, between.y - s * edge.y, between.z - s * edge.z});
        };
        take(cross(of_a[0], of_a[1])), take(cross(of_b[0], of_b[1]));
        for (const Vec& u : of_a)
            for (const Vec& v : of_b) take(cross(u, v));
        for (const Vec& u : of_a) across(u);
        for (const Vec& v : of_b) across(v);
    }
    unsigned not_shown() const { return bits(~shown_); }

private:
    Corners a_, b_; ///< relative to the nearest point of a
    F64 least_;     ///< the least width of a slab, in metres
    I64 shown_;
};

unsigned measure(const CornersOfPairs& corners, const double* rotation, const double* translation, unsigned count,
                 double rounding, NearestOfPairs& out)
{
    unsigned all_unsure = 0;
    for (unsigned first = 0; first < count; first += width) {
        const auto [a, b] = corners_of(corners, first, rotation, translation);
        const Nearest nearest = nearest_points(a, b);
        store(out.a, first, nearest.a), store(out.b, first, nearest.b);
        store(out.distance2 + first, nearest.distance2);
        Slabs slabs(a, b, nearest, sqrt(nearest.distance2), rounding);
        slabs.take(nearest.b - nearest.a);
        const unsigned wanted = (1u << (count - first)) - 1;
        if (slabs.not_shown() & wanted) slabs.take_all(nearest);
        all_unsure |= (slabs.not_shown() & wanted) << first;
    }
    return all_unsure;
}

} // namespace

MeasurePairs* measure_pairs()
{
    return measure;
}

} // namespace oncollide::ONCOLLIDE_ISA
