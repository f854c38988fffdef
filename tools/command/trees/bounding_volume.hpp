#pragma once
#include <numbers>

#include <Eigen/Core>

namespace oncollide::tools {

/// The bounding volume of a part of a surface: a sphere or an OBB. Convex and closed.
struct CoveringVolume {
    Eigen::Vector3d centre;
    Eigen::Vector3d half;                               ///< half-extents; for a sphere (radius, radius, radius)
    Eigen::Matrix3d axes = Eigen::Matrix3d::Identity(); ///< columns
    bool ball = false;

    static CoveringVolume of_ball(const Eigen::Vector3d& centre, double radius)
    {
        return {.centre = centre, .half = Eigen::Vector3d::Constant(radius), .ball = true};
    }

    /// Largest distance of its points from the centre.
    double radius() const { return ball ? half.x() : half.norm(); }
    double volume() const { return (ball ? 4 * std::numbers::pi / 3 : 8) * half.prod(); }
    /// True if a point is inside, or within `slack`. OBBs have up to sqrt(3) times `slack` at corners.
    bool holds(const Eigen::Vector3d& point, double slack) const
    {
        const Eigen::Vector3d d = point - centre;
        if (ball) return d.squaredNorm() <= (half.x() + slack) * (half.x() + slack);
        return ((axes.transpose() * d).cwiseAbs().array() <= half.array() + slack).all();
    }
    /// A point of its boundary. For a sphere: the point in that direction. For an OBB, evenly spread directions give
    /// points that are spread evenly over the faces, however flat it is; directions to the corners of a cube give its
    /// corners.
    Eigen::Vector3d boundary(const Eigen::Vector3d& direction) const
    {
        if (ball) return centre + half.x() * direction.normalized();
        const Eigen::Vector3d d = axes.transpose() * direction;
        return centre + axes * half.cwiseProduct(d / d.cwiseAbs().maxCoeff());
    }
};

} // namespace oncollide::tools
