#include "verify/oracle/segment_truth.hpp"

#include <array>
#include <optional>

#include <boost/multiprecision/cpp_int.hpp>

#include "truth/exact_point.hpp"

namespace oncollide::oracle {

namespace {

using Rational = boost::multiprecision::cpp_rational;
using Point = PointOf<Rational>;

/// The fractions that fulfil linear conditions.
struct Range {
    Rational begin = 0, end = 1;
    bool empty = false;

    /// at_0 + t slope >= 0
    void keep(const Rational& at_0, const Rational& slope)
    {
        if (slope == 0) {
            empty = empty || at_0 < 0;
        } else {
            const Rational t = -at_0 / slope;
            if (slope > 0 && t > begin) begin = t;
            if (slope < 0 && t < end) end = t;
        }
        empty = empty || begin > end;
    }
    /// at_0 + t slope == 0
    void solve(const Rational& at_0, const Rational& slope) { keep(at_0, slope), keep(-at_0, -slope); }
    std::optional<Rational> first() const { return empty ? std::nullopt : std::optional(begin); }
};

std::optional<Rational> first_of(const Segment& s, const TrianglePoints& t)
{
    const Point p = point_of<Rational>(s.from), d = point_of<Rational>(s.to) - p;
    const std::array<Point, 3> c{point_of<Rational>(t[0]), point_of<Rational>(t[1]), point_of<Rational>(t[2])};
    const Point n = cross(c[1] - c[0], c[2] - c[0]);
    Range range;
    if (n != Point{}) {
        range.solve(dot(n, p - c[0]), dot(n, d));
        for (std::size_t i = 0; i < 3; ++i) { // the inner side of each edge
            const Point inward = cross(n, c[(i + 1) % 3] - c[i]);
            range.keep(dot(inward, p - c[i]), dot(inward, d));
        }
        return range.first();
    }
    // The longest edge contains the third corner.
    std::size_t longest = 0;
    Rational length = -1;
    for (std::size_t i = 0; i < 3; ++i) {
        const Point e = c[(i + 1) % 3] - c[i];
        if (dot(e, e) > length) length = dot(e, e), longest = i;
    }
    const Point e = c[(longest + 1) % 3] - c[longest], from = p - c[longest];
    if (length == 0) {
        for (std::size_t k = 0; k < 3; ++k) range.solve(from[k], d[k]);
    } else {
        const Point at_0 = cross(from, e), slope = cross(d, e);
        for (std::size_t k = 0; k < 3; ++k) range.solve(at_0[k], slope[k]);
        range.keep(dot(from, e), dot(d, e)), range.keep(length - dot(from, e), -dot(d, e));
    }
    return range.first();
}

std::optional<Rational> first_of(const Segment& s, const Aabb& box)
{
    const Point p = point_of<Rational>(s.from), d = point_of<Rational>(s.to) - p, low = point_of<Rational>(box.min),
                high = point_of<Rational>(box.max);
    Range range;
    for (std::size_t k = 0; k < 3; ++k) range.keep(p[k] - low[k], d[k]), range.keep(high[k] - p[k], -d[k]);
    return range.first();
}

bool boxes_meet(const Segment& s, const Aabb& box)
{
    Aabb around;
    around.add(s.from), around.add(s.to);
    return around.overlaps(box);
}

} // namespace

struct SegmentTruth::Fraction {
    std::optional<Rational> value;
};

SegmentTruth::SegmentTruth() = default;
SegmentTruth::~SegmentTruth() = default;
SegmentTruth::SegmentTruth(SegmentTruth&&) noexcept = default;

void SegmentTruth::add(const Segment& segment, const TrianglePoints& triangle)
{
    Aabb box;
    for (const Eigen::Vector3d& corner : triangle) box.add(corner);
    if (boxes_meet(segment, box)) take(Fraction{first_of(segment, triangle)});
}

void SegmentTruth::add(const Segment& segment, const Aabb& box)
{
    if (boxes_meet(segment, box)) take(Fraction{first_of(segment, box)});
}

void SegmentTruth::take(const Fraction& first)
{
    if (first.value && (!first_ || *first.value < *first_->value)) first_ = std::make_unique<Fraction>(first);
}

void SegmentTruth::add_start()
{
    first_ = std::make_unique<Fraction>(Fraction{Rational(0)});
}

bool SegmentTruth::within(double lower, double upper) const
{
    return first_ && Rational(lower) <= *first_->value && *first_->value <= Rational(upper);
}

bool SegmentTruth::equals(const SegmentTruth& other) const
{
    return first_ && other.first_ && *first_->value == *other.first_->value;
}

} // namespace oncollide::oracle
