#pragma once
#include <oncollide/narrowphase/relative_pose.hpp>
#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

// The cores of two shapes (shape_core.hpp), decided exactly for B's vertices as placed in A's frame: the last resort
// where rounding hides a sign. Touching counts.

/// How far apart two solid convex polytopes, given by their surfaces, are at least: 0 where they meet, else > 0 unless
/// doubles cannot express it, though it may be far too low. Cost: 30 ns for each pair of triangles that reach into each
/// other's boxes.
double gap_of_polytopes(const Mesh& a, const Mesh& b, const RelativePose& b_to_a);

/// The same of what is within radius_a and radius_b of two cores that share no point. Each is a point, a segment, or a
/// closed convex surface. Cost: 0.2 to 2 microseconds for each pair of an edge and an edge, or a vertex and a face.
double gap_of_balls(const Mesh& a, const Mesh& b, const RelativePose& b_to_a, double radius_a, double radius_b);

} // namespace oncollide
