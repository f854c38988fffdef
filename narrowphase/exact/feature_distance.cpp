#include <oncollide/narrowphase/exact/feature_distance.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <span>

namespace oncollide {

namespace {

using Eigen::Vector3d;

/// A slab orthogonal to any direction bounds a distance from below. Coordinates are relative to one of the points;
/// rounding as in triangle_distance_kernel.cpp.
class Slab {
public:
    Slab(std::span<const Vector3d> a, std::span<const Vector3d> b, double least) : a_(a), b_(b), least_(least)
    {
        double reach = 0;
        for (const auto& points : {a, b})
            for (const Vector3d& p : points) reach = std::max(reach, (p - a[0]).cwiseAbs().sum());
        least_ += 0x1p-49 * reach;
    }
    bool is_wide(const Vector3d& axis) const
    {
        double low_a = 0, high_a = 0, low_b = std::numeric_limits<double>::infinity(), high_b = -low_b;
        for (const Vector3d& p : a_.subspan(1)) {
            const double at = axis.dot(p - a_[0]);
            low_a = std::min(low_a, at), high_a = std::max(high_a, at);
        }
        for (const Vector3d& p : b_) {
            const double at = axis.dot(p - a_[0]);
            low_b = std::min(low_b, at), high_b = std::max(high_b, at);
        }
        const double length = axis.norm();
        return length > 0x1p-450 && std::max(low_b - high_a, low_a - high_b) >= least_ * length * (1 + 0x1p-48);
    }

private:
    std::span<const Vector3d> a_, b_;
    double least_;
};

Vector3d without(const Vector3d& v, const Vector3d& edge)
{
    return v - v.dot(edge) / edge.squaredNorm() * edge;
}

double clamped(double s)
{
    return s > 0 ? std::min(s, 1.0) : 0; // 0 also for NaN, the quotient of parallel edges and of points
}

} // namespace

NearestOfSegments nearest_of_segments(const Vector3d& p, const Vector3d& q, const Vector3d& c, const Vector3d& d,
                                      double rounding, double most)
{
    // As in the kernel, divisors are squares of cross products.
    const Vector3d u = q - p, v = d - c, w = p - c, n = u.cross(v);
    double s = clamped(v.cross(w).dot(n) / n.squaredNorm());
    const double t = clamped((v.dot(w) + u.dot(v) * s) / v.squaredNorm());
    s = clamped((u.dot(v) * t - u.dot(w)) / u.squaredNorm());
    const Vector3d between = c + t * v - (p + s * u);
    const double distance = between.norm(), least = std::min(distance - rounding, most);
    if (!(least > 0)) return {s, t, distance};
    const std::array a{p, q}, b{c, d};
    const Slab slab(a, b, least);
    if (slab.is_wide(between) || slab.is_wide(n) || slab.is_wide(without(between, u)) ||
        slab.is_wide(without(between, v)))
        return {s, t, distance};
    return exact_nearest_of_segments(p, q, c, d);
}

OnTriangle nearest_on(const TrianglePoints& t, const Vector3d& point, double rounding, double most)
{
    const OnTriangle found = nearest_on(t, point);
    const Vector3d between = found.at - point;
    const double least = std::min(between.norm() - rounding, most);
    if (!(least > 0)) return found;
    const Slab slab(std::span(&point, 1), t, least);
    if (slab.is_wide(between) || slab.is_wide((t[1] - t[0]).cross(t[2] - t[0]))) return found;
    for (std::size_t k = 0; k < 3; ++k)
        if (slab.is_wide(without(between, t[(k + 1) % 3] - t[k]))) return found;
    return exact_nearest_on(t, point).nearest;
}

} // namespace oncollide
