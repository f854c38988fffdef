#include <oncollide/narrowphase/obb/fits/box_fit.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include <Eigen/Geometry>

#include <oncollide/base/memory/large_vector.hpp>

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

void BoxTriangles::start(const std::array<std::uint32_t, 8>& counts)
{
    std::ranges::copy(counts, counts_);
    number_ = std::ranges::max(counts);
    if (room_ >= number_) return;
    rows_ = std::make_unique_for_overwrite<EightTriangles[]>(room_ = number_);
    advise_huge_pages_in(rows_.get(), room_ * sizeof(EightTriangles));
}

void BoxTriangles::put_alone(unsigned k, TrianglePoints triangle)
{
    sort_corners(triangle);
    for (std::uint32_t row = 0; row < number_; ++row) put(k, row, triangle);
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
