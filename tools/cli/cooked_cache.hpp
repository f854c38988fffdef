#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>

#include <oncollide/scenes/files/mesh_file.hpp>

namespace oncollide::tools {

/// A folder of cooked meshes, named by what they were cooked from: the file's bytes, the options and the format. Any
/// number of processes may use it at once.
class CookedCache {
public:
    /// Makes the folder if need be. Throws Error{cannot_write}.
    /// @param most  bytes that its files may hold after each that was added; the oldest go first, and the new one stays
    ///              though it alone be larger
    CookedCache(std::filesystem::path folder, std::uintmax_t most);

    /// The cooked file of a mesh file, cooked unless it is there. Nothing: the mesh lies in several files (glTF beside
    /// its buffers), or is no file.
    std::optional<std::filesystem::path> cooked(const std::filesystem::path& mesh, const MeshOptions& options) const;

    /// The index of a folder of so many tiles by that name, cooked on all processors unless it is there.
    std::filesystem::path tiles(const std::string& name, std::size_t count,
                                const std::function<Mesh(std::size_t)>& make) const;

private:
    void make_room(const std::filesystem::path& keep) const;

    std::filesystem::path folder_;
    std::uintmax_t most_;
};

} // namespace oncollide::tools
