#pragma once
#include <cstdint>
#include <span>
#include <string>

#include "truth/tally.hpp"

namespace oncollide::tools {

/// Families of spheres, capsules and triangles that touch cells and boxes.
constexpr const char* tangent_families[] = {"balls on faces of cells and boxes", "balls on edges of cells and boxes",
                                            "balls on corners of cells and boxes", "capsules along edges",
                                            "triangles on cells"};

/// `count` pairs of one of these families: a sphere, a capsule or a triangle, and a cell of a map, a box, a hull or a
/// mesh of a box, touching or one unit of the grid apart, at scales of 2^-30 to 2^30 m and up to 2^26 times as far from
/// the origin. Truth: squares of integers, and linear programming for triangles. Tests the exact level, both bounding
/// volumes without it, and FCL. The pairs do not depend on the number of threads.
Tally try_tangent(const std::string& family, std::uint64_t count, int threads);

} // namespace oncollide::tools
