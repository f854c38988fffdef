#pragma once
#include <filesystem>

#include <oncollide/scenes/scene.hpp>

namespace oncollide {

/// Reads a scene file (JSON; schema in docs/scene-format.md). Paths in it are relative to the file's own folder.
/// Throws Error{no_input} or Error{bad_data}; messages begin with the path and the place in it (`bodies[3].mesh`), and
/// for an unknown key or name list the valid ones.
Scene load_scene(const std::filesystem::path& path);

/// Writes `scene` so that load_scene gives it back bit for bit (numbers in shortest round-trip form). Files that the
/// scene uses are named relative to `path`'s folder. Geometries made in code without a recipe are written beside it as
/// binary-exact OBJ (meshes) or .bt (maps). Temporary name, then renamed. Throws Error{cannot_write}.
void save_scene(const Scene& scene, const std::filesystem::path& path);

} // namespace oncollide
