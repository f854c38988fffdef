#pragma once
#include <numbers>

#include <Eigen/Core>

namespace oncollide::tools {

/// What stands for a part of a surface: a ball, or a box turned in any way. Convex and closed.
struct CoveringVolume {
    Eigen::Vector3d centre;
    Eigen::Vector3d half;                               ///< along the axes; of a ball its radius, thrice
    Eigen::Matrix3d axes = Eigen::Matrix3d::Identity(); ///< columns
    bool ball = false;

    static CoveringVolume of_ball(const Eigen::Vector3d& centre, double radius)
    {
        return {.centre = centre, .half = Eigen::Vector3d::Constant(radius), .ball = true};
    }

    /// No point is farther from the centre.
    double radius() const { return ball ? half.x() : half.norm(); }
    double volume() const { return (ball ? 4 * std::numbers::pi / 3 : 8) * half.prod(); }
    /// Is a point inside, or within `slack`? Of boxes, in some more at edges and corners.
    bool holds(const Eigen::Vector3d& point, double slack) const
    {
        const Eigen::Vector3d d = point - centre;
        if (ball) return d.squaredNorm() <= (half.x() + slack) * (half.x() + slack);
        return ((axes.transpose() * d).cwiseAbs().array() <= half.array() + slack).all();
    }
    /// A point of its boundary: of a ball the one in that direction; of a box the same directions end evenly over
    /// the faces, however flat it is, and those to the corners of a cube at its corners.
    Eigen::Vector3d boundary(const Eigen::Vector3d& direction) const
    {
        if (ball) return centre + half.x() * direction.normalized();
        const Eigen::Vector3d d = axes.transpose() * direction;
        return centre + axes * half.cwiseProduct(d / d.cwiseAbs().maxCoeff());
    }
};

} // namespace oncollide::tools
