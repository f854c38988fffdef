#pragma once
#include <algorithm>
#include <array>
#include <limits>

#include <Eigen/Geometry>

namespace oncollide::tools {

using Vector3l = Eigen::Matrix<long double, 3, 1>;
using TriangleL = std::array<Vector3l, 3>;

/// What the distance of two triangles is at least and at most.
struct DistanceRange {
    long double low, high;
};

/// How wide a gap across direction n parts them; 0 when none does. Rounding, of doubles: 2^-48 of the largest
/// coordinate.
template <class Real>
Real parted(const std::array<Eigen::Matrix<Real, 3, 1>, 3>& a, const std::array<Eigen::Matrix<Real, 3, 1>, 3>& b,
            const Eigen::Matrix<Real, 3, 1>& n)
{
    const Real length = n.norm();
    if (!(length > 0)) return 0;
    // Relative to a corner, so that far triangles lose nothing.
    Real low_a = 0, high_a = 0, low_b = std::numeric_limits<Real>::infinity(), high_b = -low_b;
    for (std::size_t k = 0; k < 3; ++k) {
        const Real x = n.dot(a[k] - a[0]), y = n.dot(b[k] - a[0]);
        low_a = std::min(low_a, x), high_a = std::max(high_a, x), low_b = std::min(low_b, y),
        high_b = std::max(high_b, y);
    }
    return std::max({low_b - high_a, low_a - high_b, Real(0)}) / length;
}

/// Any triangles, also segments and points. `high` is the distance of two points of theirs: the nearest of corners and
/// faces, edges and edges, and where an edge pierces a face. `low` is the width of a gap between parallel planes that
/// parts them, 0 when none of those tried does. Rounding: 2^-60 of the largest coordinate.
DistanceRange triangle_distance(const TriangleL& a, const TriangleL& b);

} // namespace oncollide::tools
