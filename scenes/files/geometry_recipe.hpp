#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <set>
#include <string>

#include <nlohmann/json.hpp>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/files/json/at_node.hpp>
#include <oncollide/scenes/files/scene_file.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide {

// Geometries as described in a scene file: docs/scene-format.md, "Geometries". Private to scenes.

using Json = nlohmann::json;

/// Adds the geometry that `entry` describes; its recipe is the entry with absolute paths. Zero-area triangles add a
/// line to scene.warnings. Throws Error like load_scene.
/// @param folder  the base of relative paths in the entry
GeometryId add_geometry(SceneInfo& scene, std::string_view name, const Node& entry, const std::filesystem::path& folder,
                        const SceneReading& reading = {});

/// The entry that makes `geometry` again: its recipe with paths relative to `folder`, or its data. A map or terrain
/// without a recipe gets the entry of the file `made_file`, which the caller must write.
Json entry_of(const Geometry& geometry, const std::filesystem::path& folder, const std::string& made_file);

/// Prevents a short file from filling the memory: limits the total size of geometries that are generated, or whose file
/// was used before.
class Expansion {
public:
    static constexpr std::uint64_t most_triangles = 20'000'000, most_cells = 10'000'000;

    /// Counts the geometry that was made from `entry`. Throws Error{bad_data} naming the place.
    void count(const Geometry& geometry, const Node& entry);

private:
    std::set<std::string, std::less<>> files_;
    std::uint64_t triangles_ = 0, cells_ = 0;
};

} // namespace oncollide
