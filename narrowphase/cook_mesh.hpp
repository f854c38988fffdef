#pragma once
#include <cstdint>
#include <filesystem>

#include <oncollide/scenes/cooked/cooked_format.hpp>
#include <oncollide/scenes/model/mesh.hpp>
#include <oncollide/scenes/model/occupancy_map.hpp>
#include <oncollide/scenes/model/terrain.hpp>

namespace oncollide {

/// Writes a mesh as a cooked file (docs/cooked.md): under a temporary name, then renamed. The same mesh gives the same
/// bytes. Throws Error{cannot_write}. Cost: 0.2 microseconds a triangle, most of it for the upper levels of the tree;
/// in memory at the same time the file.
/// @param chunk  triangles of a chunk, at most; from 3 to 8192. Results do not depend on it
CookedSize cook_mesh(const Mesh& mesh, const std::filesystem::path& path, std::uint32_t chunk = 8192);

/// A terrain, as it is stored: its heights at 1, 2, 4 or 8 bytes, and the bounds of each block of 64 by 64 cells. Cost:
/// 10 ns a cell.
CookedSize cook_terrain(const Terrain& terrain, const std::filesystem::path& path);

/// What is known of a map's cells, without their probabilities. Cost: 20 ns a node of its octree.
/// @param chunk  nodes of a chunk, at most, up to 4096; results do not depend on it
CookedSize cook_map(const OccupancyMap& map, const std::filesystem::path& path, std::uint32_t chunk = 4096);

/// Reads all of a cooked file, and checks what its top says against what its chunks hold. Throws Error{no_input}
/// or Error{bad_data}.
CookedSize check_cooked(const std::filesystem::path& path);

} // namespace oncollide
