#include <oncollide/narrowphase/rays/segment_entry.hpp>

#include <algorithm>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/exact/flat_triangles.hpp>
#include <oncollide/narrowphase/rays/segment_tests.hpp>
#include <oncollide/narrowphase/shapes/convex_pair.hpp>

namespace oncollide {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr SegmentEntry at_start{0, 0}, at_end{1, 1};

/// Bounds of a fraction that errs by at most 2^-49 of its magnitude, or by underflow.
SegmentEntry around(double fraction)
{
    return {std::max(fraction * (1 - 0x1p-48) - 0x1p-1000, 0.0), std::min(fraction * (1 + 0x1p-48) + 0x1p-1000, 1.0)};
}

/// The fraction at which a coordinate that goes from p to q, which differ, is x.
SegmentEntry along_axis(double p, double q, double x)
{
    return x == p ? at_start : x == q ? at_end : around(std::abs(x - p) / std::abs(q - p));
}

/// A point on a segment with length.
SegmentEntry of_point(const Segment& s, const Vector3d& point)
{
    int axis = 0;
    (s.to - s.from).cwiseAbs().maxCoeff(&axis);
    return along_axis(s.from[axis], s.to[axis], point[axis]);
}

void take(SegmentEntry& first, const SegmentEntry& next)
{
    first.lower = std::min(first.lower, next.lower), first.upper = std::min(first.upper, next.upper);
}

/// The segment meets a triangle in whose plane it lies, or a triangle without area. Their first common point is the
/// segment's start, a corner of the triangle, a crossing of an edge, or the segment's end.
SegmentEntry entry_in_plane(const Segment& segment, const TrianglePoints& triangle)
{
    const Vector3d &p = segment.from, &q = segment.to;
    const Simplex s = simplex_of({p, q, q}), t = simplex_of(triangle);
    if (t.count == 1) return of_point(segment, t.corner[0]);
    const int axis = projection_axis(s, t);
    if (holds(t, p, axis)) return at_start;
    SegmentEntry first = at_end;
    for (int i = 0; i < t.count; ++i)
        if (holds(s, t.corner[i], axis)) take(first, of_point(segment, t.corner[i]));
    for (int i = 0; axis >= 0 && i < (t.count == 3 ? 3 : 1); ++i) {
        const Vector2d a = projected(p, axis), b = projected(q, axis), c = projected(t.corner[i], axis),
                       d = projected(t.corner[(i + 1) % t.count], axis);
        if (orient2d(a, b, c) * orient2d(a, b, d) < 0 && orient2d(c, d, a) * orient2d(c, d, b) < 0)
            take(first, around(crossing_parameter(c, d, a, b)));
    }
    return first;
}

/// The axis of the face through which the segment enters a cell that it meets, and its entry; -1 if it begins there.
std::pair<int, SegmentEntry> entry_face(const Segment& s, const Aabb& cell)
{
    std::pair<int, SegmentEntry> last{-1, at_start};
    for (int k = 0; k < 3; ++k) {
        const bool below = s.from[k] < cell.min[k];
        if (!below && !(s.from[k] > cell.max[k])) continue;
        const SegmentEntry entry = along_axis(s.from[k], s.to[k], below ? cell.min[k] : cell.max[k]);
        if (last.first < 0 || entry.lower > last.second.lower) last.first = k;
        last.second = {std::max(last.second.lower, entry.lower), std::max(last.second.upper, entry.upper)};
    }
    return last;
}

} // namespace

std::optional<SegmentEntry> entry_of(const Segment& segment, const TrianglePoints& t)
{
    if (!segment_meets(segment, t)) return {};
    const Vector3d &p = segment.from, &q = segment.to;
    if (p == q) return at_start;
    const int of_p = orient3d(t[0], t[1], t[2], p), of_q = orient3d(t[0], t[1], t[2], q);
    if (!of_p && !of_q) return entry_in_plane(segment, t);
    if (!of_p || !of_q) return of_p ? at_end : at_start;
    return entry_across(segment, t);
}

SegmentEntry entry_across(const Segment& segment, const TrianglePoints& t)
{
    return around(crossing_parameter(t[0], t[1], t[2], segment.from, segment.to));
}

std::optional<SegmentEntry> entry_of(const Segment& segment, const Aabb& cell)
{
    if (!segment_meets(segment, cell)) return {};
    return entry_face(segment, cell).second;
}

std::optional<SegmentEntry> entry_in_half_space(const Segment& segment)
{
    const double p = segment.from.z(), q = segment.to.z();
    if (p <= 0) return at_start;
    if (q > 0) return {};
    return along_axis(p, q, 0);
}

std::optional<SegmentEntry> entry_of(const Segment& segment, const Convex& solid)
{
    const RelativePose same(Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity());
    // The sign for the part of the segment up to a fraction. Its end errs by 3 u of its magnitude, u = 2^-53.
    // ConvexDifference's bound has room for that: it allows 9 u for a rotation, and here there is no rotation.
    const auto sign = [&](double to) {
        const Vector3d end = to < 1 ? Vector3d((1 - to) * segment.from + to * segment.to) : segment.to;
        const TrianglePoints part{segment.from, end, end};
        return ConvexPair(solid, convex_of(part), same, to > 0 && to < 1 ? 0x1p-48 : 0).meeting().sign;
    };
    const int whole = sign(1);
    if (whole > 0) return {};
    const int start = sign(0);
    if (start < 0) return at_start;
    // Up to `apart` there is certainly no common point, and at `meets` there is one. Between `from` and `to` rounding
    // hides whether there is one.
    double apart = 0, meets = 1, from = whole < 0 ? 2 : 1, to = from;
    if (start == 0) from = 0, to = whole < 0 ? 0 : 1;
    while (from > 1 && meets - apart > 0x1p-42) {
        const double middle = 0.5 * (apart + meets);
        const int s = sign(middle);
        (s > 0 ? apart : s < 0 ? meets : from) = middle;
        if (s == 0) to = middle;
    }
    if (from <= 1) {
        while (from - apart > 0x1p-42) (sign(0.5 * (apart + from)) > 0 ? apart : from) = 0.5 * (apart + from);
        while (meets - to > 0x1p-42) (sign(0.5 * (to + meets)) < 0 ? meets : to) = 0.5 * (to + meets);
    }
    return SegmentEntry{apart, meets, whole < 0};
}

Vector3d normal_facing(const Segment& segment, const TrianglePoints& t)
{
    const int of_p = orient3d(t[0], t[1], t[2], segment.from), of_q = orient3d(t[0], t[1], t[2], segment.to);
    const int side = of_p ? of_p : -of_q;
    return side ? Vector3d(side * unit_normal(t[0], t[1], t[2])) : Vector3d::Zero();
}

Vector3d normal_facing(const Segment& segment, const Aabb& cell)
{
    const int axis = entry_face(segment, cell).first;
    if (axis < 0) return Vector3d::Zero();
    return (segment.from[axis] < cell.min[axis] ? -1.0 : 1.0) * Vector3d::Unit(axis);
}

} // namespace oncollide
