#pragma once
#include <functional>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/scenes/geometry.hpp>

namespace oncollide::tools {

using ExtendedVector = Eigen::Matrix<long double, 3, 1>;

/// A convex set by its farthest point along a direction, in world coordinates.
using ConvexSet = std::function<ExtendedVector(const ExtendedVector& direction)>;

/// Bounds on a distance, rounding of extended precision aside: `upper` is that of two points, `lower` that of two
/// planes.
struct TrueDistance {
    long double lower, upper;
};

/// By the nearest points of growing simplices; shares no code with the library.
/// Source: Gilbert, Johnson and Keerthi, "A fast procedure for computing the distance between complex objects in
/// three-dimensional space", IEEE J. Robotics and Automation 1988; each simplex by trying all of its faces.
TrueDistance convex_distance(const ConvexSet& a, const ConvexSet& b);

/// The geometry as convex sets: a shape is one, each triangle of a mesh or a terrain and each cell of a map is one. Of
/// a half-space it is a piece of 512 m.
/// @param near  in the geometry's frame: triangles and cells whose boxes do not touch it are left out
std::vector<ConvexSet> convex_sets(const GeometryData& geometry, const Eigen::Isometry3d& pose,
                                   const Aabb* near = nullptr);

/// From all of a half-space, z <= 0 before it is placed, to the nearest of the sets.
TrueDistance half_space_distance(const Eigen::Isometry3d& half_space, const std::vector<ConvexSet>& sets);
/// Of two half-spaces: 0 unless they look away from each other exactly.
TrueDistance half_spaces_distance(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b);

/// Of two bodies: the least of all pairs of sets, of which those are left out whose boxes are farther apart than
/// others were found to be. Cost: 20 microseconds a pair that is near, and a look at every part.
TrueDistance true_distance(const std::vector<ConvexSet>& a, const std::vector<ConvexSet>& b);

} // namespace oncollide::tools
