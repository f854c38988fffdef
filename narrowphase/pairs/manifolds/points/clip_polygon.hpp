#pragma once
#include <vector>

#include <Eigen/Core>

namespace oncollide {

/// Leaves the part of a convex polygon behind a plane, whose normal need not be unit. @param scratch  memory
inline void clip_behind(std::vector<Eigen::Vector3d>& polygon, const Eigen::Vector3d& normal, const Eigen::Vector3d& at,
                        std::vector<Eigen::Vector3d>& scratch)
{
    scratch.clear();
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Eigen::Vector3d &u = polygon[i], &v = polygon[(i + 1) % polygon.size()];
        const double at_u = normal.dot(u - at), at_v = normal.dot(v - at);
        if (at_u <= 0) scratch.push_back(u);
        if ((at_u < 0 && at_v > 0) || (at_u > 0 && at_v < 0)) scratch.push_back(u + at_u / (at_u - at_v) * (v - u));
    }
    polygon.swap(scratch);
}

} // namespace oncollide
