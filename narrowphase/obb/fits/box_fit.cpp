#include <oncollide/narrowphase/obb/fits/box_fit.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace oncollide {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Second moments of the surface, or of the corners if the area is 0.
Matrix3d spread_of(const TriangleColumns& triangles, const Aabb& extent)
{
    const double scale = 0x1p13 / extent.half_extent().maxCoeff();
    if (!std::isfinite(scale)) return Matrix3d::Zero();
    const Vector3d centre = extent.centre();
    SurfaceSums sums;
    box_fit_kernel().sums(triangles.fours().data(), triangles.size(), {centre.x(), centre.y(), centre.z()}, scale,
                          sums);
    const auto& [xx, yy, zz, xy, xz, yz] = sums.squares;
    Matrix3d squares;
    squares << xx, xy, xz, xy, yy, yz, xz, yz, zz;
    const Vector3d mean = Vector3d(sums.sum[0], sums.sum[1], sums.sum[2]) / (3 * sums.weight);
    return squares / (12 * sums.weight) - mean * mean.transpose();
}

/// Right-handed axes: the first along u, the last along the part of n that is orthogonal to u.
Matrix3d frame_of(const Vector3d& u, const Vector3d& n)
{
    Matrix3d axes;
    axes.col(0) = u.normalized();
    axes.col(2) = (n - axes.col(0) * axes.col(0).dot(n)).normalized();
    axes.col(1) = axes.col(2).cross(axes.col(0));
    return axes;
}

Matrix3d axes_of_triangle(TrianglePoints t)
{
    std::sort(t.begin(), t.end(), [](const Vector3d& p, const Vector3d& q) {
        return std::lexicographical_compare(p.data(), p.data() + 3, q.data(), q.data() + 3);
    });
    std::array<Vector3d, 3> sides{t[1] - t[0], t[2] - t[1], t[0] - t[2]};
    std::ranges::stable_sort(sides, std::greater{}, &Vector3d::squaredNorm);
    const double length = sides[0].norm();
    if (!(length > 0)) return Matrix3d::Identity();
    const double legs = sides[1].squaredNorm() + sides[2].squaredNorm(), longest = sides[0].squaredNorm();
    const bool right_angled = std::abs(legs - longest) < 0.001 * longest;
    const Vector3d u = sides[right_angled ? 1 : 0].normalized();
    Vector3d n = u.cross(Vector3d((t[1] - t[0]) / length)) + u.cross(Vector3d((t[2] - t[0]) / length));
    if (!(n.norm() > 1e-12)) n = u.unitOrthogonal();
    const Matrix3d axes = frame_of(u, n.normalized());
    return axes.allFinite() ? axes : Matrix3d::Identity();
}

Matrix3d axes_of_many(const TriangleColumns& triangles, const Aabb& extent)
{
    const Matrix3d spread = spread_of(triangles, extent);
    if (!(spread.cwiseAbs().maxCoeff() > 0)) return Matrix3d::Identity();
    Eigen::SelfAdjointEigenSolver<Matrix3d> solver;
    solver.computeDirect(spread);
    const Matrix3d axes = frame_of(solver.eigenvectors().col(2), solver.eigenvectors().col(0));
    return axes.allFinite() ? axes : Matrix3d::Identity();
}

} // namespace

TrianglePoints TriangleColumns::first() const
{
    TrianglePoints t;
    for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t axis = 0; axis < 3; ++axis) t[c][Eigen::Index(axis)] = fours_[0].corners[c][axis][0];
    return t;
}

Aabb extent_along(const Matrix3d& axes, const TriangleColumns& triangles)
{
    double directions[3][3];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) directions[i][j] = axes(j, i);
    double low[3], high[3];
    box_fit_kernel().extent(triangles.fours().data(), triangles.fours().size(), directions, low, high);
    return {Eigen::Map<Vector3d>(low), Eigen::Map<Vector3d>(high)};
}

Matrix3d fitted_axes(const TriangleColumns& triangles, const Aabb& bounds)
{
    return triangles.size() == 1 ? axes_of_triangle(triangles.first()) : axes_of_many(triangles, bounds);
}

} // namespace oncollide
