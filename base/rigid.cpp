#include <oncollide/base/rigid.hpp>

#include <cmath>

#include <fmt/format.h>

namespace oncollide {

std::string why_not_rigid(const Eigen::Isometry3d& pose)
{
    constexpr double tolerance = 1e-6;
    // Columns of four. The products are written out, because this is called for every pose of every frame and query.
    const double* const m = pose.data();
    const auto dot = [](const double* x, const double* y) { return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]; };
    const auto is = [](double value, double wanted) { return std::abs(value - wanted) <= tolerance; };
    const double *const x = m, *const y = m + 4, *const z = m + 8, *const t = m + 12;
    const bool orthogonal = is(dot(x, x), 1) & is(dot(y, y), 1) & is(dot(z, z), 1) & is(dot(x, y), 0) &
                            is(dot(y, z), 0) & is(dot(z, x), 0); // false for NaN
    const bool at_a_point = (t[0] - t[0] == 0) & (t[1] - t[1] == 0) & (t[2] - t[2] == 0);
    const bool affine = (x[3] == 0) & (y[3] == 0) & (z[3] == 0) & (t[3] == 1);
    const double determinant =
        x[0] * (y[1] * z[2] - y[2] * z[1]) + x[1] * (y[2] * z[0] - y[0] * z[2]) + x[2] * (y[0] * z[1] - y[1] * z[0]);
    if (orthogonal & at_a_point & affine & (determinant > 0)) return {};
    if (!pose.matrix().allFinite()) return "the pose is not finite";
    if (!affine) return "the pose's last row is not (0, 0, 0, 1)";
    if (orthogonal) return "the pose is not rigid: it mirrors (the determinant of R is negative)";
    const Eigen::Matrix3d r = pose.linear();
    return fmt::format("the pose is not rigid: R^T R differs from the identity by {:.3g}, at most {} is allowed",
                       (r.transpose() * r - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), tolerance);
}

} // namespace oncollide
