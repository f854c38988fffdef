#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include <oncollide/scenes/cooked/cooked_mesh.hpp>
#include <oncollide/scenes/files/scene_file.hpp>
#include <oncollide/scenes/scene_builder.hpp>

namespace oncollide {

/// A tile of a world of many cooked files, as listed in an index.
struct IndexedTile {
    std::string file; ///< relative to the index's folder
    CookedOutline outline;
};

/// Reads an index of tiles (docs/cooked.md, "Tiles"), but not the tiles. Throws Error{no_input} or Error{bad_data} that
/// names the place.
std::vector<IndexedTile> load_tile_index(const std::filesystem::path& path);

/// Writes to a temporary name, then renames. Throws Error{cannot_write}.
void save_tile_index(const std::filesystem::path& path, const std::vector<IndexedTile>& tiles);

/// The index entry of a cooked file. Throws as CookedMesh does.
IndexedTile index_tile(const std::filesystem::path& folder, const std::string& file);

/// Adds a geometry and a static body for each tile of an index, both named `name`/STEM, where STEM is the stem of the
/// tile's file name.
/// @param like  the other properties of these bodies; its name and geometry are ignored
/// @param reading  on demand: the tiles stay in their files; otherwise all are read
void add_tiles(SceneBuilder& scene, const std::string& name, const std::filesystem::path& index, const BodyInit& like,
               const SceneReading& reading);

} // namespace oncollide
