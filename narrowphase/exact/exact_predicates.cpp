#include <oncollide/narrowphase/exact/exact_predicates.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <oncollide/narrowphase/exact/wide_vector.hpp>

namespace oncollide {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// p / (p - q) for p and q of different signs.
template <int N>
double ratio(const WideInteger<N>& p, const WideInteger<N>& q)
{
    const WideInteger<N> sum = p.magnitude() + q.magnitude();
    const int bits = bit_length(sum);
    return scaled_down(p.magnitude(), bits) / scaled_down(sum, bits);
}

} // namespace

int orient2d_filter(const Vector2d& a, const Vector2d& b, const Vector2d& c)
{
    const double ux = b.x() - a.x(), uy = b.y() - a.y(), vx = c.x() - a.x(), vy = c.y() - a.y();
    const double left = ux * vy, right = uy * vx;
    const double value = left - right;
    const double bound = filter_bound_2d * (std::abs(left) + std::abs(right)) + filter_tiny;
    return (value > bound) - (value < -bound);
}

int orient3d_filter(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d)
{
    const Vector3d u = b - a, v = c - a, w = d - a;
    double value = 0, magnitude = 0;
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        const double left = u[i] * v[j], right = u[j] * v[i];
        value += (left - right) * w[k];
        magnitude += (std::abs(left) + std::abs(right) + filter_tiny) * std::abs(w[k]);
    }
    const double bound = filter_bound_3d * magnitude + filter_tiny;
    return (value > bound) - (value < -bound);
}

int orient2d_exact(const Vector2d& a, const Vector2d& b, const Vector2d& c)
{
    if (a == b || a == c || b == c) return 0;
    const BinaryGrid grid = grid_of_points(a, b, c);
    return with_limbs(grid, [&](auto limbs) {
        constexpr int n = decltype(limbs)::value;
        const auto u = difference<n, 2>(grid, b, a), v = difference<n, 2>(grid, c, a);
        return minor_of(u[0], u[1], v[0], v[1]).sign();
    });
}

int orient3d_exact(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d)
{
    // Frequent in meshes: shared corners, and faces orthogonal to an axis.
    if (a == b || a == c || a == d || b == c || b == d || c == d) return 0;
    for (int k = 0; k < 3; ++k)
        if (a[k] == b[k] && a[k] == c[k] && a[k] == d[k]) return 0;
    const BinaryGrid grid = grid_of_points(a, b, c, d);
    return with_limbs(grid, [&](auto limbs) {
        constexpr int n = decltype(limbs)::value;
        const auto u = difference<n, 3>(grid, b, a), v = difference<n, 3>(grid, c, a), w = difference<n, 3>(grid, d, a);
        return dot(cross<n>(u, v), w).sign();
    });
}

int orient2d(const Vector2d& a, const Vector2d& b, const Vector2d& c)
{
    const int sign = orient2d_filter(a, b, c);
    return sign ? sign : orient2d_exact(a, b, c);
}

int orient3d(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d)
{
    const int sign = orient3d_filter(a, b, c, d);
    return sign ? sign : orient3d_exact(a, b, c, d);
}

bool collinear(const Vector3d& a, const Vector3d& b, const Vector3d& c)
{
    for (int k = 0; k < 3; ++k) {
        const auto flat = [&](const Vector3d& p) { return Vector2d(p[(k + 1) % 3], p[(k + 2) % 3]); };
        if (orient2d(flat(a), flat(b), flat(c)) != 0) return false;
    }
    return true;
}

namespace {

// Extended precision for rounded results: at least 64 bits, and an exponent range that contains all products of these
// coordinates. If long double is narrower, only the exact evaluations are used.
using Extended = long double;
constexpr bool extended = std::numeric_limits<Extended>::digits >= 64;
using VectorX = Eigen::Matrix<Extended, 3, 1>;
constexpr Extended extended_unit = std::numeric_limits<Extended>::epsilon() / 2;

/// A value and its error bound.
struct Estimate {
    Extended value, error;
};

/// u x v, and the same sum with magnitudes: orient3d's determinant, with the bound of its filter.
struct ExtendedCross {
    VectorX value, magnitude;

    ExtendedCross(const VectorX& u, const VectorX& v)
    {
        for (int i = 0; i < 3; ++i) {
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            const Extended x = u[j] * v[k], y = u[k] * v[j];
            value[i] = x - y, magnitude[i] = std::abs(x) + std::abs(y);
        }
    }
    Estimate along(const VectorX& w) const
    {
        return {value[0] * w[0] + value[1] * w[1] + value[2] * w[2],
                9 * extended_unit *
                    (magnitude[0] * std::abs(w[0]) + magnitude[1] * std::abs(w[1]) + magnitude[2] * std::abs(w[2]))};
    }
};

/// p / (p - q) for numbers of different signs, if certain within 2^-50 of its magnitude.
std::optional<double> certain_ratio(const Estimate& p, const Estimate& q)
{
    const Extended apart = p.value - q.value, size = std::abs(p.value) * std::abs(apart);
    const Extended error = p.error * std::abs(apart) + (p.error + q.error) * std::abs(p.value);
    if (!(error < 0x1p-51L * size) || (p.value > 0) == (q.value > 0)) return {};
    return static_cast<double>(p.value / apart);
}

} // namespace

double crossing_parameter(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& p, const Vector3d& q)
{
    if constexpr (!extended) return crossing_parameter_exact(a, b, c, p, q);
    const VectorX from = a.cast<Extended>();
    const ExtendedCross normal(b.cast<Extended>() - from, c.cast<Extended>() - from);
    if (const auto t = certain_ratio(normal.along(p.cast<Extended>() - from), normal.along(q.cast<Extended>() - from)))
        return *t;
    return crossing_parameter_exact(a, b, c, p, q);
}

double crossing_parameter_exact(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& p,
                                const Vector3d& q)
{
    const BinaryGrid grid = grid_of_points(a, b, c, p, q);
    return with_limbs(grid, [&](auto limbs) {
        constexpr int n = decltype(limbs)::value;
        const auto normal = cross<n>(difference<n, 3>(grid, b, a), difference<n, 3>(grid, c, a));
        return ratio(dot(normal, difference<n, 3>(grid, p, a)), dot(normal, difference<n, 3>(grid, q, a)));
    });
}

double crossing_parameter(const Vector2d& a, const Vector2d& b, const Vector2d& p, const Vector2d& q)
{
    const BinaryGrid grid = grid_of_points(a, b, p, q);
    return with_limbs(grid, [&](auto limbs) {
        constexpr int n = decltype(limbs)::value;
        const auto u = difference<n, 2>(grid, b, a);
        const auto side = [&](const Vector2d& x) {
            const auto v = difference<n, 2>(grid, x, a);
            return minor_of(u[0], u[1], v[0], v[1]);
        };
        return ratio(side(p), side(q));
    });
}

Vector3d unit_normal(const Vector3d& a, const Vector3d& b, const Vector3d& c)
{
    if constexpr (!extended) return unit_normal_exact(a, b, c);
    const VectorX from = a.cast<Extended>();
    const ExtendedCross normal(b.cast<Extended>() - from, c.cast<Extended>() - from);
    const VectorX& n = normal.value;
    const Extended length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (5 * extended_unit * normal.magnitude.maxCoeff() < 0x1p-53L * length) return (n / length).cast<double>();
    return unit_normal_exact(a, b, c);
}

Vector3d unit_normal_exact(const Vector3d& a, const Vector3d& b, const Vector3d& c)
{
    const BinaryGrid grid = grid_of_points(a, b, c);
    return with_limbs(grid, [&](auto limbs) -> Vector3d {
        constexpr int n = decltype(limbs)::value;
        const auto normal = cross<n>(difference<n, 3>(grid, b, a), difference<n, 3>(grid, c, a));
        const int bits = std::max({bit_length(normal[0]), bit_length(normal[1]), bit_length(normal[2])});
        if (bits == 0) return Vector3d::Zero();
        return Vector3d(scaled_down(normal[0], bits), scaled_down(normal[1], bits), scaled_down(normal[2], bits))
            .normalized();
    });
}

} // namespace oncollide
