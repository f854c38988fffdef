#include "verify/oracle/integer_distance.hpp"

#include <algorithm>
#include <cmath>

namespace oncollide::tools {
namespace {

using WideVector = std::array<Wide, 3>;

WideVector operator-(const Place& a, const Place& b)
{
    return {Wide(a[0]) - b[0], Wide(a[1]) - b[1], Wide(a[2]) - b[2]};
}
Wide dot(const WideVector& a, const WideVector& b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
WideVector cross(const WideVector& a, const WideVector& b)
{
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

SquareLength point_to_point(const Place& a, const Place& b)
{
    const WideVector d = a - b;
    return {dot(d, d), 1};
}

SquareLength point_to_segment(const Place& p, const Place& a, const Place& b)
{
    const WideVector ab = b - a, ap = p - a;
    const Wide along = dot(ap, ab), length = dot(ab, ab);
    if (along <= 0) return point_to_point(p, a);
    if (along >= length) return point_to_point(p, b);
    const WideVector off = cross(ap, ab);
    return {dot(off, off), length};
}

SquareLength point_to_triangle(const Place& p, const PlaceTriangle& t)
{
    SquareLength least = point_to_segment(p, t[2], t[0]);
    for (std::size_t k : {0, 1}) least = std::min(least, point_to_segment(p, t[k], t[k + 1]));
    const WideVector normal = cross(t[1] - t[0], t[2] - t[0]);
    for (std::size_t k = 0; k < 3; ++k)
        if (dot(cross(t[(k + 1) % 3] - t[k], p - t[k]), normal) < 0) return least;
    const Wide height = dot(normal, p - t[0]);
    return std::min(least, SquareLength{height * height, dot(normal, normal)});
}

/// Distance of interior points of both segments, where the lines are nearest. Their ends are compared elsewhere.
SquareLength inside_segments(const Place& p, const Place& q, const Place& a, const Place& b)
{
    const WideVector u = q - p, v = b - a, w = p - a;
    const WideVector n = cross(u, v);
    const Wide square = dot(n, n);
    const SquareLength none = point_to_point(p, a);
    if (square == 0) return none;
    // p + s / square u and a + t / square v.
    const Wide s = dot(cross(v, w), n), t = dot(cross(u, w), n);
    if (s < 0 || s > square || t < 0 || t > square) return none;
    const Wide gap = dot(n, w);
    return {gap * gap, square};
}

/// True if the segment pierces the triangle. A segment in its plane is handled by its ends and edges.
bool pierces(const Place& p, const Place& q, const PlaceTriangle& t)
{
    const WideVector normal = cross(t[1] - t[0], t[2] - t[0]), u = q - p;
    const Wide from = dot(normal, p - t[0]), to = dot(normal, q - t[0]);
    if ((from > 0 && to > 0) || (from < 0 && to < 0) || from == to) return false;
    // True if the line passes all edges on the same side.
    int low = 0, high = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const Wide side = dot(u, cross(t[k] - p, t[(k + 1) % 3] - p));
        low += side<0, high += side> 0;
    }
    return low == 0 || high == 0;
}

} // namespace

/// Compares by continued fractions, because products could overflow.
bool SquareLength::operator<(const SquareLength& other) const
{
    const Wide p = numerator / denominator, q = other.numerator / other.denominator;
    if (p != q) return p < q;
    const Wide r = numerator % denominator, s = other.numerator % other.denominator;
    if (r == 0 || s == 0) return r == 0 && s != 0;
    return SquareLength{other.denominator, s} < SquareLength{denominator, r};
}

long double SquareLength::length() const
{
    return std::sqrt(static_cast<long double>(numerator) / static_cast<long double>(denominator));
}

SquareLength square_distance(const Place& from, const Place& to, const PlaceTriangle& t)
{
    SquareLength least = point_to_triangle(from, t);
    if (from == to) return least;
    if (pierces(from, to, t)) return {0, 1};
    least = std::min(least, point_to_triangle(to, t));
    for (std::size_t k = 0; k < 3; ++k) {
        least = std::min(least, point_to_segment(t[k], from, to));
        least = std::min(least, inside_segments(from, to, t[k], t[(k + 1) % 3]));
    }
    return least;
}

} // namespace oncollide::tools
