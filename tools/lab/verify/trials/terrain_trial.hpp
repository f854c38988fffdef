#pragma once
#include <cstdint>
#include <string>

#include "truth/tally.hpp"

namespace oncollide::tools {

/// Families of bodies that touch terrains.
constexpr const char* terrain_families[] = {"balls on terrain",     "capsules on terrain",    "boxes on terrain",
                                            "triangles on terrain", "half-spaces on terrain", "terrain on terrain",
                                            "terrain that is off"};

/// `count` pairs of one of these families: a terrain of a few cells, and a body that touches a face, an edge or a
/// vertex of it, or is one unit of the grid or of the last place away: spheres, capsules, cells of maps, boxes, hulls,
/// meshes, half-spaces and terrains. At 1, 2, 4 and 8 bytes per height, with holes and both diagonals, 1e-9 to 1e9 m
/// large and up to 1e8 m from the origin. In the last family heights have an error, and bounds must hold for the given
/// heights. Truth: squares of integers, and linear programming for polytopes. The pairs do not depend on the number of
/// threads.
Tally try_terrain(const std::string& family, std::uint64_t count, int threads);

} // namespace oncollide::tools
