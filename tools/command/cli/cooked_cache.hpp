#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>

#include <oncollide/scenes/files/geometry_file.hpp>

namespace oncollide::tools {

/// A folder of cooked meshes. A file's name is a hash of the source file's bytes, the options and the format version.
/// Any number of processes may use it at once.
class CookedCache {
public:
    /// Creates the folder if it does not exist. Throws Error{cannot_write}.
    /// @param most  largest sum of the files' sizes in bytes. After adding a file, the least recently used ones are
    ///              removed; the new file stays even if it alone is larger.
    CookedCache(std::filesystem::path folder, std::uintmax_t most);

    /// The cooked file of a mesh file, cooked if it is not cached. Empty if the mesh consists of several files (.gltf)
    /// or comes from standard input, or is already cooked.
    std::optional<std::filesystem::path> cooked(const std::filesystem::path& mesh, const MeshOptions& options) const;

    /// The index of a folder of `count` tiles with this name, cooked on all processors if it is not cached.
    std::filesystem::path tiles(const std::string& name, std::size_t count,
                                const std::function<Mesh(std::size_t)>& make) const;

private:
    void make_room(const std::filesystem::path& keep) const;

    std::filesystem::path folder_;
    std::uintmax_t most_;
};

} // namespace oncollide::tools
