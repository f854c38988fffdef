#pragma once
#include <oncollide/narrowphase/exact/relative_pose.hpp>
#include <oncollide/narrowphase/shapes/convex.hpp>

namespace oncollide {

/// A lower bound of the distance of two solids with flat-sided cores, exact for B's vertices as placed in A's frame: 0
/// if they meet, touching included; otherwise > 0 unless doubles cannot express it, though it may be far too low. The
/// last resort if rounding hides a sign. Cost: 30 ns for each pair of triangles that overlap the other solid's box;
/// with radii 0.2 to 2 microseconds for each pair of two edges, or of a vertex and a face.
double exact_gap(const Convex& a, const Convex& b, const RelativePose& b_to_a);

} // namespace oncollide
