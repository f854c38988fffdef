#pragma once
#include <Eigen/Geometry>

#include <oncollide/narrowphase/exact/triangle_test.hpp>
#include <oncollide/scenes/model/mesh.hpp>

#include "hard/boxed_triangles.hpp"

namespace oncollide::tools {

/// What two bodies are to each other beyond meeting, for b's corners as they round in a's frame.
struct SolidTruth {
    /// The most that any two triangles do to each other; of meshes with an inside that only touch, crossing where one
    /// of 500 points of their common box is inside both.
    TriangleContact contact = TriangleContact::separate;
    bool vague = false; ///< such points are in a region so narrow that it may be overlooked, docs/results.md
    /// The surfaces are apart, and a corner of the one is where the other, being closed, winds around it: in either
    /// direction, so that a part inside out is a cavity and a mesh inside out as a whole is like any other.
    bool enclosed = false;
};

/// Of two that touch and do not cross by their triangles.
SolidTruth touching_truth_of(const BoxedTriangles& a, const BoxedTriangles& b);

/// Independent of the library: each pair of triangles by linear programming, each corner by its winding number, both in
/// integers.
/// @param deep  they are known to cross (BodyTruth), so nothing is computed
SolidTruth solid_truth_of(const Mesh& a, const Eigen::Isometry3d& pose_a, const Mesh& b,
                          const Eigen::Isometry3d& pose_b, bool deep);

/// Some triangle has an area, and for every edge of such a triangle there is one other that runs along it the other
/// way.
bool has_inside(const Mesh& mesh);

} // namespace oncollide::tools
