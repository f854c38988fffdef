#pragma once
#include <Eigen/Geometry>

#include <oncollide/scenes/model/mesh.hpp>

#include "hard/boxed_triangles.hpp"

namespace oncollide::tools {

/// The strongest contact of two triangles of the surfaces, exactly: linear programming in integers (exact_oracle.hpp)
/// for every pair that no plane certainly separates. Stops once the contact is `enough`. Cost: 0.1 microseconds per
/// pair of triangles whose AABBs overlap, 10 to 100 if no gap is wider than rounding.
TriangleContact contact_of(const BoxedTriangles& a, const BoxedTriangles& b, TriangleContact enough);

/// Bounds on the distance of the surfaces at the stored poses. In long double: nearest points give the upper bound,
/// separating planes the lower.
struct DistanceTruth {
    double low = 0, high = 0;
    double size = 0; ///< largest coordinate relative to a's position; low and high have an error of 2^-56 of it
};
DistanceTruth distance_of(const HalvedMesh& a, const Eigen::Isometry3d& pose_a, const HalvedMesh& b,
                          const Eigen::Isometry3d& pose_b);

/// The truth about the surfaces of two meshes, without the library's trees, traversals and predicates.
struct BodyTruth {
    /// Two triangles meet, exactly, with b's vertices rounded in a's frame. Exact results promise this.
    bool collide = false;
    /// They cross deeply enough that rounding of a motion cannot separate them: an edge of one pierces a triangle of
    /// the other with 2^-30 of the bodies' size to spare on all sides.
    bool deep = false;
    DistanceTruth distance; ///< low is 0 if they collide
};
BodyTruth truth_of(const Mesh& a, const Eigen::Isometry3d& pose_a, const Mesh& b, const Eigen::Isometry3d& pose_b);

} // namespace oncollide::tools
