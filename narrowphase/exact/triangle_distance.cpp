#include <oncollide/narrowphase/exact/triangle_distance.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

namespace oncollide {

namespace {

using Eigen::Vector3d;

/// Squared distance of p to the segment from a to b.
double to_segment(const Vector3d& p, const Vector3d& a, const Vector3d& b)
{
    const Vector3d along = b - a;
    const double length2 = along.squaredNorm();
    const double t = length2 > 0 ? std::clamp(along.dot(p - a) / length2, 0.0, 1.0) : 0;
    return (p - (a + t * along)).squaredNorm();
}

/// Squared distance of p to the inside of the triangle; infinite where the nearest point is on an edge.
double to_face(const Vector3d& p, const TrianglePoints& t)
{
    constexpr double none = std::numeric_limits<double>::infinity();
    const Vector3d u = t[1] - t[0], v = t[2] - t[0], w = p - t[0], n = u.cross(v);
    const double n2 = n.squaredNorm();
    if (!(n2 > 0)) return none;
    const double s = w.cross(v).dot(n), r = u.cross(w).dot(n);
    if (s < 0 || r < 0 || s + r > n2) return none;
    const double height = w.dot(n);
    // Of a sliver the normal is not well known: there the point found decides, wherever it lies.
    const Vector3d q = t[0] + (s / n2) * u + (r / n2) * v;
    return std::max(height * height / n2, (p - q).squaredNorm());
}

/// Squared distance of the insides of two segments; infinite where they are parallel or an end is nearest.
double between_edges(const Vector3d& p, const Vector3d& u, const Vector3d& q, const Vector3d& v)
{
    constexpr double none = std::numeric_limits<double>::infinity();
    const Vector3d w = p - q;
    const double uu = u.squaredNorm(), vv = v.squaredNorm(), uv = u.dot(v), uw = u.dot(w), vw = v.dot(w);
    const double det = uu * vv - uv * uv;
    if (!(det > 0)) return none;
    const double s = (uv * vw - vv * uw) / det, t = (uu * vw - uv * uw) / det;
    if (!(s >= 0 && s <= 1 && t >= 0 && t <= 1)) return none;
    return (w + s * u - t * v).squaredNorm();
}

} // namespace

double triangle_distance(const TrianglePoints& a, const TrianglePoints& b)
{
    double least = std::numeric_limits<double>::infinity();
    for (const auto& [from, to] : {std::pair(&a, &b), std::pair(&b, &a)})
        for (const Vector3d& p : *from) {
            least = std::min(least, to_face(p, *to));
            for (std::size_t k = 0; k < 3; ++k) least = std::min(least, to_segment(p, (*to)[k], (*to)[(k + 1) % 3]));
        }
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
            least = std::min(least, between_edges(a[i], a[(i + 1) % 3] - a[i], b[j], b[(j + 1) % 3] - b[j]));
    return std::sqrt(least);
}

double corner_distance(const TrianglePoints& a, const TrianglePoints& b)
{
    double least = std::numeric_limits<double>::infinity();
    for (const Vector3d& p : a)
        for (const Vector3d& q : b) least = std::min(least, (p - q).squaredNorm());
    return std::sqrt(least);
}

} // namespace oncollide
