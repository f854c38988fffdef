#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include <oncollide/scenes/cooked/cooked_mesh.hpp>
#include <oncollide/scenes/files/scene_file.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide {

/// A tile of a world that lies in many cooked files, as an index names it.
struct IndexedTile {
    std::string file; ///< relative to the index's folder
    CookedOutline outline;
};

/// Reads an index of tiles (docs/cooked.md, "Tiles"), and of the tiles themselves nothing. Throws Error{no_input} or
/// Error{bad_data} that names the place.
std::vector<IndexedTile> load_tile_index(const std::filesystem::path& path);

/// Temporary name, then renamed. Throws Error{cannot_write}.
void save_tile_index(const std::filesystem::path& path, const std::vector<IndexedTile>& tiles);

/// What an index says of a cooked file. Throws as CookedMesh does.
IndexedTile index_tile(const std::filesystem::path& folder, const std::string& file);

/// Adds a geometry and a static body for each tile of an index, both called `name`/STEM, where STEM is that of the
/// tile's file.
/// @param like  what all these bodies have in common; their name and geometry are not read
/// @param meshes  on demand: the tiles stay in their files; else all are read
void add_tiles(Scene& scene, const std::string& name, const std::filesystem::path& index, const BodyInit& like,
               const MeshReading& meshes);

} // namespace oncollide
