#pragma once
#include <array>

#include <Eigen/Geometry>

#include <oncollide/narrowphase/shapes/convex_difference.hpp>

namespace oncollide {

/// Up to four points of a ConvexDifference, and the point of their hull nearest to 0.
struct Simplex4 {
    std::array<ConvexDifference::Point, 4> corner;
    std::array<double, 4> weight; ///< weights of the nearest point; each at least 0, with the sum 1
    int count = 0;

    /// Finds the nearest point and drops the corners that it does not need. In spite of rounding the point is in the
    /// hull, though it may then not be the nearest.
    void reduce();

    Eigen::Vector3d nearest() const
    {
        Eigen::Vector3d sum = weight[0] * corner[0].w;
        for (int i = 1; i < count; ++i) sum += weight[i] * corner[i].w;
        return sum;
    }
    Eigen::Vector3d on_a() const
    {
        Eigen::Vector3d sum = weight[0] * corner[0].a;
        for (int i = 1; i < count; ++i) sum += weight[i] * corner[i].a;
        return sum;
    }
    bool holds(const Eigen::Vector3d& w) const
    {
        for (int i = 0; i < count; ++i)
            if (corner[i].w == w) return true;
        return false;
    }
};

} // namespace oncollide
