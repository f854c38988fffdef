#pragma once
#include <oncollide/base/aabb.hpp>
#include <oncollide/narrowphase/exact/triangle_test.hpp>

namespace oncollide {

/// True if the segment and the triangle have a common point: exact for the coordinates as stored, touching counts.
/// Cost: about 15 ns; as triangle_contact() where a corner or an edge is met.
bool segment_meets(const Segment& segment, const TrianglePoints& triangle);

/// The same of a segment and a closed, solid box. Cost: about 5 ns; as cell_meets() where the segment passes within
/// rounding of an edge.
bool segment_meets(const Segment& segment, const Aabb& box);

} // namespace oncollide
