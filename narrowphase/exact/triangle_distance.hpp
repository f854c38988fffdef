#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include <oncollide/narrowphase/exact/kernels/triangle_distance_kernel.hpp>
#include <oncollide/narrowphase/exact/relative_pose.hpp>
#include <oncollide/narrowphase/exact/triangle_test.hpp>

namespace oncollide {

struct NearestPoints {
    Eigen::Vector3d a, b;
    double distance;
};

/// The nearest points of up to eight pairs of triangles that do not meet; B's triangles are moved as RelativePose does.
/// The distance of a pair minus `rounding`, metres, is a lower bound of the true distance. Cost: 250 ns for up to four
/// pairs, 300 for eight with AVX-512; twice that for pairs that are nearer than 2^-12 of their size, and 1 to 10
/// microseconds for each that only integers can measure (exact_nearest.hpp).
void measure_pairs(const CornersOfPairs& corners, const RelativePose& b_to_a, unsigned pairs, double rounding,
                   NearestOfPairs& out);

/// The nearest points of pair `i`.
inline NearestPoints points_of(const NearestOfPairs& of, unsigned i)
{
    return {{of.a[0][i], of.a[1][i], of.a[2][i]}, {of.b[0][i], of.b[1][i], of.b[2][i]}, std::sqrt(of.distance2[i])};
}

/// 2^-40 times the largest difference of two coordinates plus 2^-49 times the largest coordinate, metres: an error that
/// doubles nearly always keep to. With a much smaller one, integers would measure nearly every pair.
double usual_rounding(const TrianglePoints& a, const TrianglePoints& b);

/// The nearest points of two triangles that do not meet, and their distance, which errs by at most `rounding`, metres.
NearestPoints nearest_points(const TrianglePoints& a, const TrianglePoints& b, double rounding);
/// The same for the nearest of the triangles `a`; the first of equally near ones. Cost: for eight hardly more than for
/// one.
NearestPoints nearest_points(std::span<const TrianglePoints> a, const TrianglePoints& b, double rounding);

/// Distance of two triangles that do not meet, metres: errs by at most usual_rounding(), also for nearly parallel edges
/// and for slivers. Cost: as measure_pairs(). Source: Ericson, "Real-Time
/// Collision Detection", 2004, 5.1.5 and 5.1.9.
double triangle_distance(const TrianglePoints& a, const TrianglePoints& b);

/// A point of a triangle, and the corners of the feature that it is on: bits 0 to 2; all of them for the face.
struct OnTriangle {
    Eigen::Vector3d at;
    std::uint8_t corners;
};
/// The nearest point of a triangle; for a triangle without area, a point that need not be the nearest. Cost: 20 ns.
/// Source: Ericson, "Real-Time Collision Detection", 2004, 5.1.5.
OnTriangle nearest_on(const TrianglePoints& triangle, const Eigen::Vector3d& point);

/// Least distance of a corner of one to a corner of the other: an upper bound of the triangles' distance. Cost: 5 ns.
double corner_distance(const TrianglePoints& a, const TrianglePoints& b);

} // namespace oncollide
