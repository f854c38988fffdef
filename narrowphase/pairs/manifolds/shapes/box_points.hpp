#pragma once
#include <oncollide/narrowphase/exact/relative_pose.hpp>
#include <oncollide/narrowphase/pairs/manifolds/shapes/few_points.hpp>
#include <oncollide/narrowphase/shapes/convex.hpp>

namespace oncollide {

/// The points of two boxes across a normal: the corners of the part of one box's face that lies over a face of the
/// other, as ContactPoints finds them for any faces, in a third of the time. False: the normal is more oblique than
/// `least`, a cosine, to all faces.
/// @param normal  unit, from A to B, in A's frame
/// @param rounding  metres: a point may lie this far outside of the face
bool find_box_points(const Convex& a, const Convex& b, const RelativePose& b_to_a, const Eigen::Vector3d& normal,
                     double least, double rounding, FewPoints& points);

} // namespace oncollide
