#pragma once
#include <filesystem>
#include <functional>
#include <optional>

#include <oncollide/scenes/files/mesh_file.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide {

/// How a scene reads its meshes.
struct MeshReading {
    bool on_demand = false; ///< meshes in cooked files stay there, and are read in parts as tests need them
    /// The cooked file to use instead of a mesh file; the mesh file may be missing; empty: the mesh file is read.
    std::function<std::optional<std::filesystem::path>(const std::filesystem::path&, const MeshOptions&)> cooked{};
};

/// Reads a scene file (JSON; schema in docs/scene-format.md). Paths in it are relative to the file's own folder. "-" is
/// standard input, whose folder is the current one. Throws Error{no_input} or Error{bad_data}; messages begin with the
/// path and the place in it (`bodies[3].mesh`), and for an unknown key or name list the valid ones.
/// @param sink  receives the bodies; null: the scene stores them. A scene whose "exclude" names bodies, not numbers,
///   stores its bodies in any case.
Scene load_scene(const std::filesystem::path& path, const MeshReading& meshes = {}, BodySink* sink = nullptr);

/// Writes `scene` with its poses at frame 0 (start_poses), so that load_scene restores it bit for bit: every number is
/// written in a form that reads back exactly. Paths of files that the scene uses are relative to `path`'s folder.
/// Geometries made in code without a recipe are written into the scene file (meshes) or beside it as `.bt` files
/// (maps). Temporary name, then renamed. Throws Error{cannot_write}.
void save_scene(const Scene& scene, const std::filesystem::path& path);

} // namespace oncollide
