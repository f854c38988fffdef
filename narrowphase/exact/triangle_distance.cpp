#include <oncollide/narrowphase/exact/triangle_distance.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

namespace oncollide {

namespace {

using Eigen::Vector3d;

/// The nearest pair of points so far, one of each triangle.
struct Nearest {
    Vector3d a = Vector3d::Zero(), b = Vector3d::Zero();
    double distance2 = std::numeric_limits<double>::infinity();

    void take(const Vector3d& p, const Vector3d& q, double d2)
    {
        if (d2 < distance2) a = p, b = q, distance2 = d2;
    }
    /// p against the segment from `from` to `to`.
    void take_edge(const Vector3d& p, const Vector3d& from, const Vector3d& to)
    {
        const Vector3d along = to - from;
        const double length2 = along.squaredNorm();
        const double t = length2 > 0 ? std::clamp(along.dot(p - from) / length2, 0.0, 1.0) : 0;
        const Vector3d q = from + t * along;
        take(p, q, (p - q).squaredNorm());
    }
    /// p against the inside of the triangle.
    void take_face(const Vector3d& p, const TrianglePoints& t)
    {
        const Vector3d u = t[1] - t[0], v = t[2] - t[0], w = p - t[0], n = u.cross(v);
        const double n2 = n.squaredNorm();
        if (!(n2 > 0)) return;
        const double s = w.cross(v).dot(n), r = u.cross(w).dot(n);
        if (s < 0 || r < 0 || s + r > n2) return;
        const double height = w.dot(n);
        // Of a sliver the normal is not well known: there the point found decides, wherever it lies.
        const Vector3d q = t[0] + (s / n2) * u + (r / n2) * v;
        take(p, q, std::max(height * height / n2, (p - q).squaredNorm()));
    }
    /// The insides of two segments that are not parallel.
    void take_edges(const Vector3d& p, const Vector3d& u, const Vector3d& q, const Vector3d& v)
    {
        const Vector3d w = p - q;
        const double uu = u.squaredNorm(), vv = v.squaredNorm(), uv = u.dot(v), uw = u.dot(w), vw = v.dot(w);
        const double det = uu * vv - uv * uv;
        if (!(det > 0)) return;
        const double s = (uv * vw - vv * uw) / det, t = (uu * vw - uv * uw) / det;
        if (s >= 0 && s <= 1 && t >= 0 && t <= 1) take(p + s * u, q + t * v, (w + s * u - t * v).squaredNorm());
    }
};

void take_corners(Nearest& nearest, const TrianglePoints& corners, const TrianglePoints& t)
{
    for (const Vector3d& p : corners) {
        nearest.take_face(p, t);
        for (std::size_t k = 0; k < 3; ++k) nearest.take_edge(p, t[k], t[(k + 1) % 3]);
    }
}

} // namespace

NearestPoints nearest_points(const TrianglePoints& a, const TrianglePoints& b)
{
    Nearest nearest;
    take_corners(nearest, b, a);
    std::swap(nearest.a, nearest.b);
    take_corners(nearest, a, b);
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
            nearest.take_edges(a[i], a[(i + 1) % 3] - a[i], b[j], b[(j + 1) % 3] - b[j]);
    return {nearest.a, nearest.b, std::sqrt(nearest.distance2)};
}

double triangle_distance(const TrianglePoints& a, const TrianglePoints& b)
{
    return nearest_points(a, b).distance;
}

double corner_distance(const TrianglePoints& a, const TrianglePoints& b)
{
    double least = std::numeric_limits<double>::infinity();
    for (const Vector3d& p : a)
        for (const Vector3d& q : b) least = std::min(least, (p - q).squaredNorm());
    return std::sqrt(least);
}

} // namespace oncollide
