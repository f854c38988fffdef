#pragma once
#include <oncollide/narrowphase/exact/triangle_test.hpp>

namespace oncollide {

/// A certified lower bound of the distance of two triangles, metres, for their coordinates as stored: > 0 unless they
/// meet or doubles cannot express it (below 2^-1022), however near they are. It is the largest gap along the axes that
/// are normal to a face, to two edges, or to an edge and a coordinate axis; triangles that are apart have a gap along
/// one of them. Cost: 2 to 10 microseconds, all in integers; triangle_distance() gives the same bound for triangles
/// whose distance exceeds the rounding errors.
/// @param axis  out, unless null: the unit direction of the gap, from a to b; 0 if there is none
double triangle_gap(const TrianglePoints& a, const TrianglePoints& b, Eigen::Vector3d* axis = nullptr);

/// The least distance that triangles with such coordinates can have unless they meet: coarser, and 100 times as fast.
double least_possible_gap(const TrianglePoints& a, const TrianglePoints& b);

} // namespace oncollide
