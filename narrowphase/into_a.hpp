#pragma once
#include <Eigen/Geometry>

namespace oncollide {

/// Moves points of B into A's frame, in double: what the exact level calls their coordinates. All who ask must get the
/// same bits, so the operations and their order are fixed; the triangle kernel does the same.
struct IntoA {
    Eigen::Matrix3d turn;
    Eigen::Vector3d shift;

    IntoA(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b)
        : turn(a.linear().transpose() * b.linear()), shift(a.linear().transpose() * (b.translation() - a.translation()))
    {
    }
    Eigen::Vector3d operator()(const Eigen::Vector3d& p) const
    {
        const auto row = [&](int i) {
            return turn(i, 0) * p.x() + (turn(i, 1) * p.y() + turn(i, 2) * p.z()) + shift[i];
        };
        return {row(0), row(1), row(2)};
    }
};

} // namespace oncollide
