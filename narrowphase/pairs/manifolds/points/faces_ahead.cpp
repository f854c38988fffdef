#include <oncollide/narrowphase/pairs/manifolds/points/faces_ahead.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <oncollide/narrowphase/pairs/manifolds/points/manifold_limits.hpp>

namespace oncollide {

using Eigen::Vector3d;

void FacesAhead::set(std::span<const NumberedTriangle> all, const Vector3d& direction)
{
    faces_.clear();
    if (!all.empty()) origin_ = all.front().points[0];
    for (const auto& [number, t] : all) {
        const Vector3d from = t[0] - origin_, u = t[1] - t[0], v = t[2] - t[0], n = u.cross(v);
        const double length = n.norm(), slope = direction.dot(n);
        if (!(slope > manifold_limits::least_slope * length)) continue;
        Face face{-n / slope,
                  v.cross(direction) / slope,
                  direction.cross(u) / slope,
                  0,
                  0,
                  0,
                  length / slope,
                  u.norm() + v.norm(),
                  number};
        face.depth_0 = -face.depth.dot(from);
        face.second_0 = -face.second.dot(from), face.third_0 = -face.third.dot(from);
        faces_.push_back(face);
    }
}

const FacesAhead::Face* FacesAhead::nearest(const Vector3d& p, double& depth, double& beside_by) const
{
    constexpr double beside = manifold_limits::beside_face;
    const Vector3d at = p - origin_;
    const Face* nearest = nullptr;
    depth = std::numeric_limits<double>::infinity();
    for (const Face& face : faces_) {
        const double s = face.second.dot(at) + face.second_0, r = face.third.dot(at) + face.third_0;
        if (s < -beside || r < -beside || s + r > 1 + beside) continue;
        const double d = face.depth.dot(at) + face.depth_0;
        if (std::abs(d) < std::abs(depth))
            depth = d, nearest = &face, beside_by = face.size * std::max({-s, -r, s + r - 1, 0.0});
    }
    return nearest;
}

} // namespace oncollide
