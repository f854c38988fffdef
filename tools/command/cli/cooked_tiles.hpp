#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide::tools {

constexpr const char* tile_index_name = "tiles.json"; ///< name of the index file in a folder of tiles

struct TilesSize {
    std::uint64_t tiles = 0, triangles = 0, bytes = 0;
};

/// Writes `count` meshes as cooked files into a folder, on all processors, and then the index. make(i) returns the
/// file's name without extension, and the mesh. Throws Error{cannot_write}.
TilesSize cook_tiles(const std::filesystem::path& folder, std::size_t count,
                     const std::function<std::pair<std::string, Mesh>(std::size_t)>& make, bool quiet);

/// Reads all tiles of an index and checks each against its entry. Throws Error{no_input} or Error{bad_data}.
TilesSize check_tiles(const std::filesystem::path& index);

/// A mesh cut along x and y into columns x rows. A triangle belongs to the tile that holds the centre of its AABB.
class MeshTiles {
public:
    /// Keeps a reference to `mesh`.
    MeshTiles(const Mesh& mesh, int columns, int rows);

    std::size_t size() const { return tiles_.size(); } ///< number of tiles that have triangles
    std::string name(std::size_t i) const;             ///< "COLUMN-ROW"
    Mesh mesh(std::size_t i) const;

private:
    struct Tile {
        std::uint32_t column, row;
        std::vector<std::uint32_t> triangles;
    };
    const Mesh& mesh_;
    std::vector<Tile> tiles_;
};

} // namespace oncollide::tools
