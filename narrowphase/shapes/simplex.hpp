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
    /// A direction across the edge or the face of the corners, on the side of `toward`; `toward` itself for other
    /// simplices.
    Eigen::Vector3d across(const Eigen::Vector3d& toward) const
    {
        if (count != 2 && count != 3) return toward;
        const Eigen::Vector3d edge = corner[1].w - corner[0].w;
        if (count == 2) return toward - edge.dot(toward) / edge.squaredNorm() * edge;
        const Eigen::Vector3d normal = edge.cross(corner[2].w - corner[0].w);
        return normal.dot(toward) < 0 ? Eigen::Vector3d(-normal) : normal;
    }
    bool holds(const Eigen::Vector3d& w) const
    {
        for (int i = 0; i < count; ++i)
            if (corner[i].w == w) return true;
        return false;
    }
};

} // namespace oncollide
