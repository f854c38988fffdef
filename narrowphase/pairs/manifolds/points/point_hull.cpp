#include <oncollide/narrowphase/pairs/manifolds/points/point_hull.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include <oncollide/narrowphase/pairs/manifolds/points/manifold_limits.hpp>

namespace oncollide {

using Eigen::Vector3d;

PointHull::PointHull(std::span<const ManifoldPoint> points)
{
    for (const ManifoldPoint& p : points) points_.push_back(middle_of(p));
    const std::size_t count = points_.size();
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t j = i + 1; j < count; ++j) {
            const Vector3d way = points_[j] - points_[i];
            const double length2 = way.squaredNorm();
            sides_.push_back({points_[i], way, length2 > 0 ? 1 / length2 : 0});
        }
    const std::size_t firsts =
        count > manifold_limits::most_hull_points ? 1 : count; // all triangles where they are few, else a fan
    for (std::size_t i = 0; i < firsts; ++i)
        for (std::size_t j = i + 1; j < count; ++j)
            for (std::size_t k = j + 1; k < count; ++k) {
                const Vector3d n = (points_[j] - points_[i]).cross(points_[k] - points_[i]);
                if (!(n.squaredNorm() > 0)) continue;
                Face face{n.normalized(), {}, {}, 0};
                const std::size_t corners[] = {i, j, k};
                for (int e = 0; e < 3; ++e) {
                    const Vector3d &from = points_[corners[e]], &to = points_[corners[(e + 1) % 3]];
                    face.inward[e] = face.normal.cross(to - from), face.least[e] = face.inward[e].dot(from);
                }
                face.height = face.normal.dot(points_[i]);
                faces_.push_back(face);
            }
}

double PointHull::distance2(const Vector3d& p, double enough) const
{
    double least = std::numeric_limits<double>::infinity();
    for (const Vector3d& q : points_) least = std::min(least, (p - q).squaredNorm());
    for (const Face& f : faces_) {
        if (least <= enough) return least;
        if (f.inward[0].dot(p) < f.least[0] || f.inward[1].dot(p) < f.least[1] || f.inward[2].dot(p) < f.least[2])
            continue;
        const double height = f.normal.dot(p) - f.height;
        least = std::min(least, height * height);
    }
    for (const Side& s : sides_) {
        if (least <= enough) return least;
        const double at = std::clamp(s.way.dot(p - s.from) * s.inverse, 0.0, 1.0);
        least = std::min(least, (p - s.from - at * s.way).squaredNorm());
    }
    return least;
}

double most_lost(std::span<const ManifoldPoint> kept, std::span<const ManifoldPoint> left_out)
{
    if (kept.empty()) return 0;
    const PointHull hull(kept);
    double most = 0;
    // The distance from a hull is convex, so the hull of all points is no farther from it than the farthest point.
    for (const ManifoldPoint& p : left_out) most = std::max(most, hull.distance2(middle_of(p)));
    return std::sqrt(most) * (1 + 0x1p-40);
}

} // namespace oncollide
