#include "cli/cooked_tiles.hpp"

#include <algorithm>
#include <atomic>
#include <mutex>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/narrowphase/cook_mesh.hpp>
#include <oncollide/scenes/files/tile_index.hpp>

#include "cli/progress.hpp"

namespace oncollide::tools {

namespace fs = std::filesystem;

TilesSize cook_tiles(const fs::path& folder, std::size_t count,
                     const std::function<std::pair<std::string, Mesh>(std::size_t)>& make, bool quiet)
{
    std::error_code error;
    fs::create_directories(folder, error);
    if (!fs::is_directory(folder, error))
        throw Error(ErrorKind::cannot_write,
                    fmt::format("'{}' is not a folder and cannot be created", folder.string()));
    fs::remove(folder / tile_index_name, error); // the index is out of date from here on
    std::vector<IndexedTile> tiles(count);
    std::atomic<std::uint64_t> bytes = 0, triangles = 0;
    std::mutex mutex; // guards `progress`
    Progress progress("tile", count, quiet);
    parallel_chunks(count, 1, hardware_threads(), [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            const auto [name, mesh] = make(i);
            const std::string file = name + ".cooked";
            bytes += cook_mesh(mesh, folder / file).bytes, triangles += mesh.triangles.size();
            tiles[i] = index_tile(folder, file);
            const std::lock_guard lock(mutex);
            progress.step();
        }
    });
    save_tile_index(folder / tile_index_name, tiles);
    return {count, triangles, bytes};
}

TilesSize check_tiles(const fs::path& index)
{
    TilesSize size;
    for (const IndexedTile& tile : load_tile_index(index)) {
        const fs::path file = index.parent_path() / tile.file;
        CookedMesh(file, tile.outline).open();
        ++size.tiles, size.triangles += tile.outline.triangles, size.bytes += check_cooked(file).bytes;
    }
    return size;
}

MeshTiles::MeshTiles(const Mesh& mesh, int columns, int rows) : mesh_(mesh)
{
    const Eigen::Vector3d low = mesh.bounds.min, size = mesh.bounds.max - low;
    const auto place = [&](double at, int axis, int count) {
        const double share = size[axis] > 0 ? (at - low[axis]) / size[axis] : 0;
        return std::clamp(static_cast<int>(share * count), 0, count - 1);
    };
    std::vector<Tile> all(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        Aabb box;
        for (const std::uint32_t v : mesh.triangles[t]) box.add(mesh.vertices[v]);
        const int column = place(box.centre().x(), 0, columns), row = place(box.centre().y(), 1, rows);
        Tile& tile =
            all[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column)];
        tile.column = static_cast<std::uint32_t>(column), tile.row = static_cast<std::uint32_t>(row);
        tile.triangles.push_back(t);
    }
    for (Tile& tile : all)
        if (!tile.triangles.empty()) tiles_.push_back(std::move(tile));
}

std::string MeshTiles::name(std::size_t i) const
{
    return fmt::format("{}-{}", tiles_[i].column, tiles_[i].row);
}

/// Keeps the mesh's order of vertices.
Mesh MeshTiles::mesh(std::size_t i) const
{
    std::vector<std::uint32_t> used;
    for (const std::uint32_t t : tiles_[i].triangles)
        used.insert(used.end(), mesh_.triangles[t].begin(), mesh_.triangles[t].end());
    std::ranges::sort(used);
    used.erase(std::unique(used.begin(), used.end()), used.end());
    std::vector<Eigen::Vector3d> vertices;
    for (const std::uint32_t v : used) vertices.push_back(mesh_.vertices[v]);
    std::vector<Triangle> triangles;
    for (const std::uint32_t t : tiles_[i].triangles) {
        Triangle& triangle = triangles.emplace_back();
        for (std::size_t k = 0; k < 3; ++k)
            triangle[k] =
                static_cast<std::uint32_t>(std::ranges::lower_bound(used, mesh_.triangles[t][k]) - used.begin());
    }
    return make_mesh(name(i), std::move(vertices), std::move(triangles));
}

} // namespace oncollide::tools
