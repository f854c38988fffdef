#pragma once
#include <Eigen/Geometry>

#include <oncollide/narrowphase/exact/triangle_test.hpp>
#include <oncollide/scenes/model/mesh.hpp>

#include "hard/boxed_triangles.hpp"

namespace oncollide::tools {

/// Relation of two solids, with b's vertices rounded in a's frame.
struct SolidTruth {
    /// The strongest contact of two triangles; for meshes with an inside that only touch: crossing if one of 500 points
    /// in the intersection of their AABBs is inside both.
    TriangleContact contact = TriangleContact::separate;
    bool vague = false; ///< that intersection is so thin that the library may overlook it, docs/results.md
    /// The surfaces are apart, and the other, being closed, winds around a vertex of one of them. Either orientation
    /// counts, so a part inside out is a cavity, and a mesh that is inside out as a whole is like any other.
    bool enclosed = false;
};

/// The truth about two solids whose triangles touch but do not cross.
SolidTruth touching_truth_of(const BoxedTriangles& a, const BoxedTriangles& b);

/// Independent of the library: linear programming for each pair of triangles and the winding number of each vertex,
/// both in integers.
/// @param deep  they are known to cross (BodyTruth), so nothing is computed
SolidTruth solid_truth_of(const Mesh& a, const Eigen::Isometry3d& pose_a, const Mesh& b,
                          const Eigen::Isometry3d& pose_b, bool deep);

/// True if some triangle has an area, and every edge of such a triangle is shared by one other triangle in the opposite
/// direction.
bool has_inside(const Mesh& mesh);

} // namespace oncollide::tools
