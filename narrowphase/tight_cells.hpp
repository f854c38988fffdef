#pragma once
#include <oncollide/narrowphase/octant_cell.hpp>
#include <oncollide/narrowphase/tight_block.hpp>

namespace oncollide {

/// Plain spheres for all octants.
TightBlock plain_block();

/// Bounds what the surface has in each of the octants `grey` of `cell`, slack and quantising included.
///
/// The ball is that around the boxes of the triangles, cut to the octant. The planes lie across the mean normal. A
/// triangle reaches no farther along it than its corners do, nor than its plane does inside the ball: so triangles much
/// larger than the octant bound it well.
/// Octants of many triangles keep the plain sphere: so large a part of a surface is no disc.
/// @param found  the triangles of the cell, with the octants that each enters
/// Cost: about 60 ns a triangle and octant.
TightBlock bound_octants(const Surface& surface, const OctantCell& cell, const TriangleSpan& found, unsigned grey);

} // namespace oncollide
