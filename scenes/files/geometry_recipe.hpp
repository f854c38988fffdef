#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <set>
#include <string>

#include <nlohmann/json.hpp>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/files/json/json_node.hpp>
#include <oncollide/scenes/files/scene_file.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide {

// Geometries as a scene file describes them: docs/scene-format.md, "Geometries". Private to scenes.

using Json = nlohmann::json;

/// Adds the geometry that `entry` describes; its recipe is the entry with absolute paths. Zero-area triangles become a
/// line in scene.warnings. Throws Error like load_scene.
/// @param folder  what relative paths in the entry are relative to
GeometryId add_geometry(Scene& scene, std::string_view name, const Node& entry, const std::filesystem::path& folder,
                        const MeshReading& meshes = {});

/// The same for code that writes the entry itself; paths are relative to the current folder.
GeometryId add_geometry(Scene& scene, const std::string& name, const Json& entry);

/// The entry that makes `geometry` again: its recipe with paths relative to `folder`, or its data written out. A map
/// or terrain without a recipe gets the entry of the file `made_file`, to be written by the caller.
Json entry_of(const Geometry& geometry, const std::filesystem::path& folder, const std::string& made_file);

/// Calls `work`, putting the node's place in front of what it throws, unless that names a place in the node already.
/// Wrong arguments are wrong data in a file.
template <class Work>
auto at(const Node& node, Work work)
{
    try {
        return work();
    } catch (const Error& error) {
        const ErrorKind kind = error.kind() == ErrorKind::usage ? ErrorKind::bad_data : error.kind();
        const std::string place = node.place(), what = error.what();
        throw Error(kind, what.starts_with(printable(place)) ? what : place + ": " + what);
    }
}

/// Keeps a short file from filling the memory: what its geometries are made of without a text or file of their own,
/// which are the generated ones and files named before, is limited for all of them together.
class Expansion {
public:
    static constexpr std::uint64_t most_triangles = 20'000'000, most_cells = 10'000'000;

    /// Of the geometry that `entry` has just become. Throws Error{bad_data} naming the place.
    void count(const Geometry& geometry, const Node& entry);

private:
    std::set<std::string, std::less<>> files_;
    std::uint64_t triangles_ = 0, cells_ = 0;
};

} // namespace oncollide
