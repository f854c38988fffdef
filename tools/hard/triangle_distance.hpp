#pragma once
#include <array>

#include <Eigen/Geometry>

namespace oncollide::tools {

using Vector3l = Eigen::Matrix<long double, 3, 1>;
using TriangleL = std::array<Vector3l, 3>;

/// What the distance of two triangles is at least and at most.
struct DistanceRange {
    long double low, high;
};

/// Any triangles, also segments and points. `high` is the distance of two points of theirs: the nearest of corners and
/// faces, edges and edges, and where an edge pierces a face. `low` is the width of a gap between parallel planes that
/// parts them, 0 when none of those tried does. Rounding: 2^-60 of the largest coordinate.
DistanceRange triangle_distance(const TriangleL& a, const TriangleL& b);

} // namespace oncollide::tools
