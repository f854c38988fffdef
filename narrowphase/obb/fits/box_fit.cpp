#include <oncollide/narrowphase/obb/fits/box_fit.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include <Eigen/Geometry>

namespace oncollide {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Right-handed axes: the first along u, the last along the part of n that is orthogonal to u.
Matrix3d frame_of(const Vector3d& u, const Vector3d& n)
{
    Matrix3d axes;
    axes.col(0) = u.normalized();
    axes.col(2) = (n - axes.col(0) * axes.col(0).dot(n)).normalized();
    axes.col(1) = axes.col(2).cross(axes.col(0));
    return axes;
}

/// The order of a triangle's corners decides which of two equal sides is the longest.
void sort_corners(TrianglePoints& t)
{
    std::sort(t.begin(), t.end(), [](const Vector3d& p, const Vector3d& q) {
        return std::lexicographical_compare(p.data(), p.data() + 3, q.data(), q.data() + 3);
    });
}

} // namespace

void BoxFit::start(std::uint32_t rows)
{
    number_ = rows;
    if (room_ < rows) rows_ = std::make_unique_for_overwrite<EightTriangles[]>(room_ = rows);
}

void BoxFit::put_alone(unsigned k, TrianglePoints triangle)
{
    sort_corners(triangle);
    for (std::uint32_t row = 0; row < number_; ++row) put(k, row, triangle);
}

void BoxFit::fit_one(unsigned k, std::uint32_t count, const StoredFrame& frame, StoredBoxes& boxes) const
{
    std::uint32_t counts[8];
    for (std::uint32_t lane = 0; lane < 8; ++lane) counts[lane] = (count + 7 - lane) / 8;
    StoredBoxes alike;
    box_fit_kernel().fit_one(rows_.get(), counts, frame, alike);
    for (int axis = 0; axis < 3; ++axis)
        boxes.place[axis][k] = alike.place[axis][0], boxes.half[axis][k] = alike.half[axis][0];
    for (int part = 0; part < 4; ++part) boxes.turn[part][k] = alike.turn[part][0];
}

Matrix3d axes_of_triangle(TrianglePoints t)
{
    sort_corners(t);
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

} // namespace oncollide
