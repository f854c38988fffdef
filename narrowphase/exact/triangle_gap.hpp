#pragma once
#include <oncollide/narrowphase/exact/triangle_test.hpp>

namespace oncollide {

/// A certified lower bound on the distance of two triangles, metres, for their coordinates as stored: > 0 unless they
/// meet or doubles cannot express it (below 2^-1022), however near they are. It is the widest gap that an axis square
/// to a face, to two edges, or to an edge and a coordinate axis shows; where triangles are apart, one of these does.
/// Cost: 2 to 10 microseconds, all in integers; triangle_distance() says the same of triangles that rounding leaves
/// apart.
double triangle_gap(const TrianglePoints& a, const TrianglePoints& b);

/// The least distance that triangles of such coordinates can have unless they meet: coarser, and 100 times as fast.
double least_possible_gap(const TrianglePoints& a, const TrianglePoints& b);

} // namespace oncollide
