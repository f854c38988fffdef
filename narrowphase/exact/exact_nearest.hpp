#pragma once
#include <oncollide/narrowphase/exact/triangle_distance.hpp>

namespace oncollide {

// Nearest points in integers: the nearest features are found without rounding, for coordinates as stored, at any angle,
// thickness and scale. Distances are within 2^-45 of their magnitude, unless doubles cannot express it; points err by
// the rounding of their own coordinates. They serve the cases in which doubles fail: edges that are nearly parallel,
// and triangles that are nearly segments (docs/stability.md#numerical-stability). Cost: 1 to 10 microseconds, 100 and
// more if the coordinates' magnitudes are more than 2^200 apart.

/// The nearest points of two triangles that do not meet.
NearestPoints exact_nearest_points(const TrianglePoints& a, const TrianglePoints& b);

/// A point and the nearest point of a triangle.
struct ExactOnTriangle {
    OnTriangle nearest;
    double distance;
};
ExactOnTriangle exact_nearest_on(const TrianglePoints& triangle, const Eigen::Vector3d& point);

/// The parameters of the nearest points of the segments pq and cd, p + s (q - p) and c + t (d - c), and their
/// distance.
struct NearestOfSegments {
    double s, t, distance;
};
NearestOfSegments exact_nearest_of_segments(const Eigen::Vector3d& p, const Eigen::Vector3d& q,
                                            const Eigen::Vector3d& c, const Eigen::Vector3d& d);

} // namespace oncollide
