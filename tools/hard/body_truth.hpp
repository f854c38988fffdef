#pragma once
#include <Eigen/Geometry>

#include <oncollide/scenes/model/mesh.hpp>

#include "hard/boxed_triangles.hpp"

namespace oncollide::tools {

/// The most that two triangles of the surfaces do to each other where they stand, exactly: linear programming in
/// integers (exact_oracle.hpp) wherever no plane surely parts them. Looks no further once that is `enough`.
/// Cost: 0.1 microseconds a pair of triangles whose boxes overlap, 10 to 100 where no gap is wider than rounding.
TriangleContact contact_of(const BoxedTriangles& a, const BoxedTriangles& b, TriangleContact enough);

/// The distance of the surfaces at the poses as stored is between these. In long double: nearest points bound it from
/// above, parting planes from below.
struct DistanceTruth {
    double low = 0, high = 0;
    double size = 0; ///< largest coordinate about a's place: the others err by 2^-56 of it
};
DistanceTruth distance_of(const HalvedMesh& a, const Eigen::Isometry3d& pose_a, const HalvedMesh& b,
                          const Eigen::Isometry3d& pose_b);

/// The truth about the surfaces of two meshes, independent of the library: no trees, walks or predicates of it.
struct BodyTruth {
    /// Two triangles meet, exactly, where b's corners are as they round in a's frame: what exact answers promise.
    bool collide = false;
    /// They cross so far that no motion's rounding parts them: an edge of one pierces a triangle of the other with
    /// 2^-30 of the bodies' size to spare on all sides.
    bool deep = false;
    DistanceTruth distance; ///< low is 0 when they collide
};
BodyTruth truth_of(const Mesh& a, const Eigen::Isometry3d& pose_a, const Mesh& b, const Eigen::Isometry3d& pose_b);

} // namespace oncollide::tools
