#pragma once
#include "clash/parts/part_list.hpp"

namespace oncollide::tools {

/// True if two parts have the same triangles at their poses, in any order: corresponding vertices are at most the
/// tolerance apart, or the rounding of floats (2^-22 of the largest coordinate), where that is more. Cost: a comparison
/// of two poses for parts that share a mesh, else one pass over the vertices and a sort of the triangles.
bool same_geometry(const PartList& list, const Part& a, const Part& b, double tolerance);

} // namespace oncollide::tools
