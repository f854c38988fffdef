#pragma once
#include <Eigen/Geometry>

namespace oncollide {

/// Moves points of B into A's frame, in double: what the exact level calls their coordinates. All callers must get the
/// same bits, so the operations and their order are fixed; the triangle kernel does the same.
struct RelativePose {
    Eigen::Matrix3d rotation;
    Eigen::Vector3d translation;

    RelativePose(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b)
        : rotation(a.linear().transpose() * b.linear()),
          translation(a.linear().transpose() * (b.translation() - a.translation()))
    {
        // Rounding must not turn one body against the other: two copies of a mesh in one place lie on each other.
        if (a.linear() == b.linear()) rotation.setIdentity();
    }
    Eigen::Vector3d operator()(const Eigen::Vector3d& p) const
    {
        const auto row = [&](int i) {
            return rotation(i, 0) * p.x() + (rotation(i, 1) * p.y() + rotation(i, 2) * p.z()) + translation[i];
        };
        return {row(0), row(1), row(2)};
    }
};

} // namespace oncollide
