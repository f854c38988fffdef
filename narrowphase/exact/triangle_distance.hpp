#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include <oncollide/narrowphase/exact/kernels/triangle_distance_kernel.hpp>
#include <oncollide/narrowphase/exact/triangle_test.hpp>

namespace oncollide {

struct NearestPoints {
    Eigen::Vector3d a, b;
    double distance;
};

/// The build of the kernel for this processor and this number of pairs. Cost: 250 ns for up to four pairs, 300 for
/// eight with AVX-512.
MeasurePairs* measure_pairs(std::size_t pairs);

/// The nearest points of pair `i`.
inline NearestPoints points_of(const NearestOfPairs& of, unsigned i)
{
    return {{of.a[0][i], of.a[1][i], of.a[2][i]}, {of.b[0][i], of.b[1][i], of.b[2][i]}, std::sqrt(of.distance2[i])};
}

/// The nearest points of two triangles that do not meet, and their distance as by triangle_distance().
NearestPoints nearest_points(const TrianglePoints& a, const TrianglePoints& b);
/// The same for the nearest of the triangles `a`; the first of equally near ones. Cost: for eight hardly more than for
/// one.
NearestPoints nearest_points(std::span<const TrianglePoints> a, const TrianglePoints& b);

/// Distance of two triangles that do not meet, metres. Except for rounding it is the distance of two of their points:
/// it errs by at most 2^-40 times the largest difference of two coordinates. Cost: about 250 ns. Source: Ericson,
/// "Real-Time Collision Detection", 2004, 5.1.5 and 5.1.9.
double triangle_distance(const TrianglePoints& a, const TrianglePoints& b);

/// A point of a triangle, and the corners of the feature that it is on: bits 0 to 2; all of them for the face.
struct OnTriangle {
    Eigen::Vector3d at;
    std::uint8_t corners;
};
/// The nearest point of a triangle; of a triangle without area, a point that need not be the nearest. Cost: 20 ns.
/// Source: Ericson, "Real-Time Collision Detection", 2004, 5.1.5.
OnTriangle nearest_on(const TrianglePoints& triangle, const Eigen::Vector3d& point);

/// Least distance of a corner of one to a corner of the other: an upper bound of the triangles' distance. Cost: 5 ns.
double corner_distance(const TrianglePoints& a, const TrianglePoints& b);

} // namespace oncollide
