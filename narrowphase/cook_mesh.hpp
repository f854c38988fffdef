#pragma once
#include <cstdint>
#include <filesystem>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/geometry.hpp>

namespace oncollide {

/// Writes a mesh as a cooked file (docs/cooked.md), under a temporary name that is then renamed. The same mesh gives
/// the same bytes. Throws Error{cannot_write}. Cost: 0.2 microseconds per triangle, most of it for the upper levels of
/// the tree; memory: the whole file.
/// @param chunk  maximum triangles per chunk, from 3 to 8192; results do not depend on it
ONCOLLIDE_API CookedSize cook_mesh(const Mesh& mesh, const std::filesystem::path& path, std::uint32_t chunk = 8192);

/// Writes a terrain as it is stored: its heights at 1, 2, 4 or 8 bytes, and the bounds of each block of 64 by 64 cells.
/// Cost: 10 ns per cell.
ONCOLLIDE_API CookedSize cook_terrain(const Terrain& terrain, const std::filesystem::path& path);

/// Writes the state of a map's cells, without their probabilities. Cost: 20 ns per node of its octree.
/// @param chunk  maximum nodes per chunk, up to 4096; results do not depend on it
ONCOLLIDE_API CookedSize cook_map(const OccupancyMap& map, const std::filesystem::path& path,
                                  std::uint32_t chunk = 4096);

/// Reads all of a cooked file and checks its header and top against its chunks. Throws Error{no_input} or
/// Error{bad_data}.
ONCOLLIDE_API CookedSize check_cooked(const std::filesystem::path& path);

} // namespace oncollide
