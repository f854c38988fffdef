#pragma once
#include <Eigen/Geometry>

namespace oncollide {

/// Moves points of B into A's frame, in double; the exact level is exact for the coordinates so rounded. All callers
/// must get the same bits, so the operations and their order are fixed; the triangle kernel repeats them.
struct RelativePose {
    Eigen::Matrix3d rotation;
    Eigen::Vector3d translation;

    RelativePose(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b)
    {
        const double* const of_a = a.data(); // columns of four
        const double* const of_b = b.data();
        const auto along = [&](int i, double x, double y, double z) {
            return of_a[4 * i] * x + of_a[4 * i + 1] * y + of_a[4 * i + 2] * z;
        };
        for (int j = 0; j < 3; ++j)
            for (int i = 0; i < 3; ++i) rotation(i, j) = along(i, of_b[4 * j], of_b[4 * j + 1], of_b[4 * j + 2]);
        for (int i = 0; i < 3; ++i)
            translation[i] = along(i, of_b[12] - of_a[12], of_b[13] - of_a[13], of_b[14] - of_a[14]);
        // Rounding must not rotate one body against the other: two copies of a mesh at the same pose must coincide.
        if (a.linear() == b.linear()) rotation.setIdentity();
    }
    /// From the world's frame into A's: RelativePose(a, identity).
    explicit RelativePose(const Eigen::Isometry3d& a)
        : rotation(a.linear().transpose()), translation(a.linear().transpose() * (-a.translation()))
    {
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
