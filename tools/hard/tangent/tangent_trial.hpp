#pragma once
#include <cstdint>
#include <span>
#include <string>

#include "hard/tally.hpp"

namespace oncollide::tools {

/// What spheres, capsules and triangles touch in these families.
constexpr const char* tangent_families[] = {"balls on faces of cells and boxes", "balls on edges of cells and boxes",
                                            "balls on corners of cells and boxes", "capsules along edges",
                                            "triangles on cells"};

/// `count` pairs of one of these families: a sphere, a capsule or a triangle that touches a cell of a map, a box, a
/// hull or a mesh of a box, or is a unit of the grid off it, at scales of 2^-30 to 2^30 m and up to 2^26 times as far
/// from the origin. Truth: squares of integers, and linear programming for triangles. By exact tests, by both bounding
/// volumes alone, and by FCL. The same pairs for any number of threads.
Tally try_tangent(const std::string& family, std::uint64_t count, int threads);

} // namespace oncollide::tools
