#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>

#include <oncollide/scenes/geometry.hpp>

namespace oncollide {

/// Reads a mesh, a map or a terrain from a file of any format, with default options, as load_mesh, load_octomap and
/// load_terrain do; its name is the path. A cooked mesh stays in its file: tests read the parts that they need. Throws
/// as those functions do. Cost: theirs.
std::shared_ptr<Geometry> load_geometry(const std::filesystem::path& path);

/// The kind of geometry that a file holds, by its extension; mesh for an unknown extension. `cooked` may hold each
/// kind.
enum class FileKind : std::uint8_t { mesh, map, terrain, cooked };
FileKind kind_of_file(const std::filesystem::path& path);

} // namespace oncollide
