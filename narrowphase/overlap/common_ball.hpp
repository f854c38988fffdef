#pragma once
#include <limits>

#include <Eigen/Geometry>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// When the search for a ball ends.
struct CommonBallOptions {
    double enough = 0;     ///< metres: a radius that is certainly no larger need not be known more closely
    double relative = .01; ///< else the bounds are this near to each other
    /// Boxes that are examined for the radius, and for the volume. Then the bounds stay as they are.
    int most_boxes = 20'000, most_boxes_for_volume = 0;
    double relative_volume = .05;
};

/// The largest ball inside both of two solids that no face of either cuts: its centre is the point that lies deepest
/// below both surfaces.
struct CommonBall {
    double radius_lower = 0, radius_upper = std::numeric_limits<double>::infinity(); ///< certified, metres
    Eigen::Vector3d centre = Eigen::Vector3d::Zero(); ///< of a ball of the lower radius, if that is > 0; world frame
    /// Certified bounds of the volume that is inside both, if most_boxes_for_volume > 0 and the ball may be larger than
    /// `enough`.
    double volume_lower = 0, volume_upper = std::numeric_limits<double>::infinity();
};

/// Searches the overlap of two closed meshes. A point is inside a mesh whose surface winds around it, in either
/// direction.
///
/// Branch and bound over boxes: the depth of a point below both surfaces changes by no more than the point moves. Where
/// few flat faces pass through a box, half-spaces bound it better: a gap or an overlap of rounding errors between two
/// large faces needs few boxes. A ball between faces that face each other needs few boxes, too: FacingBound.
/// Cost: O(triangles), and 2 to 10 microseconds for each box. Two bars that cross need some tens of boxes, a window
/// frame in its opening some thousands.
CommonBall common_ball(const Mesh& a, const Eigen::Isometry3d& pose_a, const Mesh& b, const Eigen::Isometry3d& pose_b,
                       const CommonBallOptions& options = {});

} // namespace oncollide
