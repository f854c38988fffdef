#pragma once
#include <limits>

#include <oncollide/narrowphase/exact/exact_nearest.hpp>

namespace oncollide {

// Nearest points of features, certified: distances err by at most `rounding`, metres, at any angle and thickness.
// Distances that are certainly above `most` may err by more. Doubles find the points, and a slab between the features
// shows that no other points are nearer; where no slab is wide enough, integers measure (exact_nearest.hpp). `rounding`
// must be well above the rounding of the coordinates, 2^-52 of them: otherwise integers measure every pair. Cost: 15 to
// 40 ns; for integers 1 to 5 microseconds.

NearestOfSegments nearest_of_segments(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::Vector3d& c,
                                      const Eigen::Vector3d& d, double rounding,
                                      double most = std::numeric_limits<double>::infinity());

OnTriangle nearest_on(const TrianglePoints& triangle, const Eigen::Vector3d& point, double rounding,
                      double most = std::numeric_limits<double>::infinity());

} // namespace oncollide
