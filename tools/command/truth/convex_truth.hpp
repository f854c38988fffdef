#pragma once
#include <array>
#include <functional>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/scenes/geometry.hpp>

namespace oncollide::tools {

using ExtendedVector = Eigen::Matrix<long double, 3, 1>;

/// A convex set as its support function: the extreme point along a direction, in world coordinates.
using ConvexSet = std::function<ExtendedVector(const ExtendedVector& direction)>;

/// Bounds on a distance, apart from the rounding of extended precision: `upper` is the distance of two points, `lower`
/// of two separating planes.
struct TrueDistance {
    long double lower, upper;
};

std::array<Eigen::Vector3d, 8> corners_of(const Aabb& box);

/// GJK: nearest points of growing simplices; shares no code with the library.
/// Source: Gilbert, Johnson and Keerthi, "A fast procedure for computing the distance between complex objects in
/// three-dimensional space", IEEE J. Robotics and Automation 1988; each simplex is solved by trying all of its faces.
TrueDistance convex_distance(const ConvexSet& a, const ConvexSet& b);

/// The geometry as convex sets: one set per shape, triangle of a mesh or a terrain, or cell of a map. A half-space is
/// represented by a piece of 512 m.
/// @param near  in the geometry's frame: triangles and cells whose AABBs do not touch it are left out
std::vector<ConvexSet> convex_sets(const GeometryData& geometry, const Eigen::Isometry3d& pose,
                                   const Aabb* near = nullptr);

/// Distance of a whole half-space (z <= 0 in its own frame) to the nearest of the sets.
TrueDistance half_space_distance(const Eigen::Isometry3d& half_space, const std::vector<ConvexSet>& sets);
/// Distance of two half-spaces: 0 unless their normals are exactly opposite.
TrueDistance half_spaces_distance(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b);

/// Distance of two bodies: the minimum over all pairs of sets. Pairs whose AABBs are farther apart than a known
/// distance are skipped. Cost: 20 microseconds per near pair, and an AABB test per part.
TrueDistance true_distance(const std::vector<ConvexSet>& a, const std::vector<ConvexSet>& b);

} // namespace oncollide::tools
