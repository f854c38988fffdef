#pragma once
#include <algorithm>
#include <array>
#include <limits>

#include <Eigen/Geometry>

namespace oncollide::tools {

using Vector3l = Eigen::Matrix<long double, 3, 1>;
using TriangleL = std::array<Vector3l, 3>;

/// Lower and upper bound of the distance of two triangles.
struct DistanceRange {
    long double low, high;
};

/// Width of the gap between the projections onto n; 0 if they overlap. Rounding, for doubles: 2^-48 of the largest
/// coordinate.
template <class Real>
Real parted(const std::array<Eigen::Matrix<Real, 3, 1>, 3>& a, const std::array<Eigen::Matrix<Real, 3, 1>, 3>& b,
            const Eigen::Matrix<Real, 3, 1>& n)
{
    const Real length = n.norm();
    if (!(length > 0)) return 0;
    // Relative to a vertex, so that triangles far from the origin lose no precision.
    Real low_a = 0, high_a = 0, low_b = std::numeric_limits<Real>::infinity(), high_b = -low_b;
    for (std::size_t k = 0; k < 3; ++k) {
        const Real x = n.dot(a[k] - a[0]), y = n.dot(b[k] - a[0]);
        low_a = std::min(low_a, x), high_a = std::max(high_a, x), low_b = std::min(low_b, y),
        high_b = std::max(high_b, y);
    }
    return std::max({low_b - high_a, low_a - high_b, Real(0)}) / length;
}

/// For any triangles, also degenerate ones. `high` is the distance of two of their points: the nearest of vertices and
/// faces, of edges and edges, and where an edge pierces a face. `low` is the width of a gap between parallel separating
/// planes, 0 if none of the planes tried separates them. Rounding: 2^-60 of the largest coordinate.
DistanceRange triangle_distance(const TriangleL& a, const TriangleL& b);

} // namespace oncollide::tools
