#pragma once
#include <Eigen/Geometry>

#include <oncollide/scenes/mesh.hpp>

namespace oncollide::tools {

/// The truth about the surfaces of two meshes, by brute force over their triangles.
struct BodyTruth {
    /// Two triangles meet, exactly, where b's corners are as they round in a's frame: what exact answers promise.
    bool collide = false;
    /// They cross so far that no motion's rounding parts them: an edge of one pierces a triangle of the other with
    /// 2^-30 of the bodies' size to spare on all sides.
    bool deep = false;
    double low = 0, high = 0; ///< the distance at the poses as stored is between these; 0 and about 0 when they collide
    double size = 0; ///< largest coordinate about a's place: the distances err by 2^-56 of it, meshes and poses given
};

/// Independent of the library: `collide` by linear programming in integers (exact_oracle.hpp), distances in long double
/// from nearest points, which bound it from above, and parting planes, which bound it from below.
/// Cost: about 2 microseconds a pair of triangles whose boxes are nearer than the bodies, 10 to 100 where boxes
/// overlap.
BodyTruth truth_of(const Mesh& a, const Eigen::Isometry3d& pose_a, const Mesh& b, const Eigen::Isometry3d& pose_b);

} // namespace oncollide::tools
