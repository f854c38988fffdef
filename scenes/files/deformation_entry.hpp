#pragma once
#include <filesystem>
#include <memory>

#include <nlohmann/json.hpp>

#include <oncollide/scenes/files/json/json_node.hpp>
#include <oncollide/scenes/files/scene_file.hpp>

namespace oncollide {

// Deformations as described in a scene file: docs/scene-format.md, "Meshes that deform". Private to scenes.

using Json = nlohmann::json;

/// Its recipe is the entry with an absolute path. Throws Error like load_scene.
std::shared_ptr<Deformation> read_deformation(const Node& entry, const std::filesystem::path& folder);

/// The entry that makes the deformation again, with paths relative to `folder`. Throws Error{cannot_write} if none
/// does.
/// @param geometry  its name, for errors
Json entry_of(const Deformation& deformation, const std::filesystem::path& folder, const std::string& geometry);

} // namespace oncollide
