#include <oncollide/narrowphase/exact/exact_nearest.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include <oncollide/narrowphase/exact/wide_vector.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3d;

/// A number at least 0, mantissa * 2^exponent, of any magnitude: the mantissa is in [1/2, 1), or 0.
struct Scaled {
    double mantissa = 0;
    int exponent = 0;

    bool operator<(const Scaled& other) const
    {
        if (mantissa == 0 || other.mantissa == 0) return mantissa < other.mantissa;
        return exponent != other.exponent ? exponent < other.exponent : mantissa < other.mantissa;
    }
    /// The square root times 2^shift.
    double root(int shift) const
    {
        const int odd = exponent & 1;
        return std::ldexp(std::sqrt(std::ldexp(mantissa, odd)), (exponent - odd) / 2 + shift);
    }
};

/// p / q, within 2^-49 of its magnitude; q > 0.
template <int P, int Q>
Scaled quotient(const WideInteger<P>& p, const WideInteger<Q>& q)
{
    const int bits_p = bit_length(p), bits_q = bit_length(q);
    Scaled result;
    result.mantissa = std::frexp(scaled_down(p, bits_p) / scaled_down(q, bits_q), &result.exponent);
    result.exponent += bits_p - bits_q;
    return result;
}
/// The same for 0 <= p <= q, as a double.
template <int P, int Q>
double share(const WideInteger<P>& p, const WideInteger<Q>& q)
{
    const int bits = bit_length(q);
    return scaled_down(p, bits) / scaled_down(q, bits);
}

Vector3d on_segment(const Vector3d& p, const Vector3d& q, double s)
{
    return s == 1 ? q : Vector3d(p + s * (q - p));
}

/// The squared distance from the nearest point of a segment, in units of the grid, and where that point is.
struct ToSegment {
    Scaled squared;
    double at; ///< 0 and 1 only at the ends
};
/// The same for two points of lines, if both are on the segments.
struct ToLine {
    Scaled squared;
    double s, t;
};

template <int N>
using Difference = WideVector<N, 3>;

template <int N>
ToSegment to_segment(const Difference<N>& from_start, const Difference<N>& from_end, const Difference<N>& edge)
{
    const WideInteger<1> one{{1}};
    const WideInteger<2 *N> along = dot(edge, from_start), length2 = dot(edge, edge);
    if (along.sign() <= 0) return {quotient(dot(from_start, from_start), one), 0};
    if ((along - length2).sign() >= 0) return {quotient(dot(from_end, from_end), one), 1};
    const auto across = cross<N>(edge, from_start);
    // If rounding makes a share 0 or 1, the point is still between the ends.
    const double at = std::clamp(share(along, length2), std::numeric_limits<double>::min(),
                                 1 - std::numeric_limits<double>::epsilon());
    return {quotient(dot(across, across), length2), at};
}

/// @param w  the vector from the start of v to the start of u
template <int N>
bool to_line(const Difference<N>& u, const Difference<N>& v, const Difference<N>& w, ToLine& found)
{
    const auto n = cross<N>(u, v);
    const WideInteger<4 *N> n2 = dot(n, n), s = dot(cross<N>(v, w), n), t = dot(cross<N>(u, w), n);
    if (n2.sign() == 0 || s.sign() <= 0 || t.sign() <= 0 || (s - n2).sign() >= 0 || (t - n2).sign() >= 0) return false;
    const WideInteger<3 * N> height = dot(n, w);
    found = {quotient(height * height, n2), share(s, n2), share(t, n2)};
    return true;
}

/// A point above the inside of a face.
struct ToFace {
    Scaled squared;
    double u, v; ///< the foot is corner 0 + u (corner 1 - corner 0) + v (corner 2 - corner 0)
};
/// @param w  the vector from corner 0 to the point
template <int N>
bool to_face(const Difference<N>& u, const Difference<N>& v, const Difference<N>& w, ToFace& found)
{
    const auto n = cross<N>(u, v);
    const WideInteger<4 *N> n2 = dot(n, n), along_u = dot(cross<N>(w, v), n), along_v = dot(cross<N>(u, w), n);
    if (along_u.sign() <= 0 || along_v.sign() <= 0 || (along_u + along_v - n2).sign() >= 0) return false;
    const WideInteger<3 * N> height = dot(n, w);
    found = {quotient(height * height, n2), share(along_u, n2), share(along_v, n2)};
    return true;
}

constexpr std::size_t next(std::size_t k)
{
    return (k + 1) % 3;
}

/// Calls visit(grid, f) with f(to, from) = to - from in limbs wide enough for the coordinates of all points.
template <class... Points>
auto on_common_grid(auto visit, const Points&... points)
{
    const BinaryGrid grid = grid_of_points(points...);
    return with_limbs(grid, [&](auto limbs) {
        constexpr int n = decltype(limbs)::value;
        return visit(grid.exponent,
                     [&](const Vector3d& to, const Vector3d& from) { return difference<n, 3>(grid, to, from); });
    });
}

} // namespace

NearestPoints exact_nearest_points(const TrianglePoints& a, const TrianglePoints& b)
{
    return on_common_grid(
        [&](int exponent, auto between) {
            using D = decltype(between(a[0], a[0]));
            std::array<D, 3> edge_a, edge_b;
            std::array<std::array<D, 3>, 3> apart; // the vector from b's corner to a's: [a][b]
            for (std::size_t i = 0; i < 3; ++i) {
                edge_a[i] = between(a[next(i)], a[i]), edge_b[i] = between(b[next(i)], b[i]);
                for (std::size_t j = 0; j < 3; ++j) apart[i][j] = between(a[i], b[j]);
            }
            const auto back = [](D d) {
                for (auto& x : d) x = -x;
                return d;
            };
            NearestPoints nearest{};
            Scaled least{1, std::numeric_limits<int>::max()};
            const auto take = [&](const Scaled& squared, auto points) {
                if (squared < least) least = squared, std::tie(nearest.a, nearest.b) = points();
            };
            using Points = std::pair<Vector3d, Vector3d>;
            for (std::size_t i = 0; i < 3; ++i)
                for (std::size_t j = 0; j < 3; ++j) {
                    const ToSegment of_a = to_segment(apart[i][j], apart[i][next(j)], edge_b[j]);
                    take(of_a.squared, [&] { return Points(a[i], on_segment(b[j], b[next(j)], of_a.at)); });
                    const ToSegment of_b = to_segment(back(apart[i][j]), back(apart[next(i)][j]), edge_a[i]);
                    take(of_b.squared, [&] { return Points(on_segment(a[i], a[next(i)], of_b.at), b[j]); });
                    if (ToLine line; to_line(edge_a[i], edge_b[j], apart[i][j], line))
                        take(line.squared, [&] {
                            return Points(on_segment(a[i], a[next(i)], line.s), on_segment(b[j], b[next(j)], line.t));
                        });
                }
            const auto foot = [](const TrianglePoints& t, const ToFace& f) -> Vector3d {
                return t[0] + f.u * (t[1] - t[0]) + f.v * (t[2] - t[0]);
            };
            const D third_a = back(edge_a[2]), third_b = back(edge_b[2]);
            for (std::size_t k = 0; k < 3; ++k) {
                ToFace face;
                if (to_face(edge_b[0], third_b, apart[k][0], face))
                    take(face.squared, [&] { return Points(a[k], foot(b, face)); });
                if (to_face(edge_a[0], third_a, back(apart[0][k]), face))
                    take(face.squared, [&] { return Points(foot(a, face), b[k]); });
            }
            nearest.distance = least.root(exponent);
            return nearest;
        },
        a[0], a[1], a[2], b[0], b[1], b[2]);
}

ExactOnTriangle exact_nearest_on(const TrianglePoints& t, const Vector3d& point)
{
    return on_common_grid(
        [&](int exponent, auto between) {
            ExactOnTriangle found{};
            Scaled least{1, std::numeric_limits<int>::max()};
            const auto take = [&](const Scaled& squared, const Vector3d& at, unsigned corners) {
                if (squared < least) least = squared, found.nearest = {at, static_cast<std::uint8_t>(corners)};
            };
            for (std::size_t k = 0; k < 3; ++k) {
                const auto to = to_segment(between(point, t[k]), between(point, t[next(k)]), between(t[next(k)], t[k]));
                take(to.squared, on_segment(t[k], t[next(k)], to.at),
                     (to.at < 1 ? 1u << k : 0) | (to.at > 0 ? 1u << next(k) : 0));
            }
            ToFace face;
            if (to_face(between(t[1], t[0]), between(t[2], t[0]), between(point, t[0]), face))
                take(face.squared, t[0] + face.u * (t[1] - t[0]) + face.v * (t[2] - t[0]), 7);
            found.distance = least.root(exponent);
            return found;
        },
        t[0], t[1], t[2], point);
}

NearestOfSegments exact_nearest_of_segments(const Vector3d& p, const Vector3d& q, const Vector3d& c, const Vector3d& d)
{
    return on_common_grid(
        [&](int exponent, auto between) {
            NearestOfSegments found{};
            Scaled least{1, std::numeric_limits<int>::max()};
            const auto take = [&](const Scaled& squared, double s, double t) {
                if (squared < least) least = squared, found.s = s, found.t = t;
            };
            const auto u = between(q, p), v = between(d, c);
            const auto from_p = to_segment(between(p, c), between(p, d), v),
                       from_q = to_segment(between(q, c), between(q, d), v),
                       from_c = to_segment(between(c, p), between(c, q), u),
                       from_d = to_segment(between(d, p), between(d, q), u);
            take(from_p.squared, 0, from_p.at), take(from_q.squared, 1, from_q.at);
            take(from_c.squared, from_c.at, 0), take(from_d.squared, from_d.at, 1);
            if (ToLine line; to_line(u, v, between(p, c), line)) take(line.squared, line.s, line.t);
            found.distance = least.root(exponent);
            return found;
        },
        p, q, c, d);
}

} // namespace oncollide
