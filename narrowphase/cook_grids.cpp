#include <oncollide/narrowphase/cook_grids.hpp>

#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include <oncollide/narrowphase/cook_mesh.hpp>
#include <oncollide/narrowphase/inside/parts.hpp>
#include <oncollide/narrowphase/obb/terrain_tree.hpp>
#include <oncollide/scenes/cooked/cooked_map.hpp>
#include <oncollide/scenes/cooked/cooked_terrain.hpp>
#include <oncollide/scenes/cooked/cooked_writer.hpp>
#include <oncollide/scenes/model/map/map_access.hpp>

namespace oncollide {

namespace {

constexpr std::uint32_t block_side = TerrainChunks::side;
constexpr std::size_t most_parts = 1 << 16; ///< connected parts that a terrain's file stores; with more, it stores none

/// Calls visit(x, y) for all blocks of block_side by block_side cells.
template <class Visit>
void each_block(const Terrain& terrain, Visit visit)
{
    for (std::uint32_t y = 0; y < (terrain.cells_y() + block_side - 1) / block_side; ++y)
        for (std::uint32_t x = 0; x < (terrain.cells_x() + block_side - 1) / block_side; ++x) visit(x, y);
}

} // namespace

CookedSize cook_terrain(const Terrain& terrain, const std::filesystem::path& path)
{
    CookedWriter file;
    const CookedTerrainRecord record = CookedTerrain::record_of(terrain);
    CookedHeader& header = file.header;
    header.coordinate_bytes = static_cast<std::uint32_t>(terrain.bytes_per_height());
    header.triangles = 2 * terrain.cells(), header.vertices = std::uint64_t(terrain.columns()) * terrain.rows();
    file.set_bounds(terrain.bounds());
    file.record.add(record);
    if (const auto parts = part_points_of(terrain); parts.size() <= most_parts) file.set_parts(parts);
    const TerrainTree tree(terrain);
    each_block(terrain, [&](std::uint32_t x, std::uint32_t y) { file.nodes.add(tree.range_of_chunk(x, y)); });
    const std::size_t chunks = std::size_t((terrain.columns() + block_side - 1) / block_side) *
                               ((terrain.rows() + block_side - 1) / block_side);
    file.data.reserve(terrain.bytes() + chunks * block_side * 8);
    for (std::size_t chunk = 0; chunk < chunks; ++chunk)
        CookedTerrain::add_chunk(terrain, chunk, file.data), file.end_chunk();
    file.write(path, CookedKind::terrain);
    return {header.file_bytes, header.chunks};
}

CookedSize cook_map(const OccupancyMap& map, const std::filesystem::path& path, std::uint32_t chunk)
{
    CookedWriter file;
    add_map(map, std::clamp(chunk, 1u, most_chunk_nodes), file);
    file.write(path, CookedKind::map);
    return {file.header.file_bytes, file.header.chunks};
}

std::size_t check_cooked_terrain(const std::filesystem::path& path)
{
    const auto cooked = std::make_shared<const CookedTerrain>(path);
    const Terrain terrain = CookedTerrainChunks::terrain(cooked);
    const TerrainTree tree(terrain);
    std::uint64_t cells = 0;
    each_block(terrain, [&](std::uint32_t x, std::uint32_t y) { tree.range_of_chunk(x, y); });
    std::vector<bool> there;
    for (std::uint32_t y = 0; y < terrain.cells_y(); ++y) {
        terrain.read_cells(y, there);
        cells += static_cast<std::uint64_t>(std::ranges::count(there, true));
    }
    if (cells != terrain.cells()) cooked->file().refuse(fmt::format("has {} cells, not {}", cells, terrain.cells()));
    return cooked->chunks();
}

std::size_t check_cooked_map(const std::filesystem::path& path)
{
    const auto cooked = std::make_shared<const CookedMap>(path);
    const OccupancyMap map = CookedMapChunks::map(cooked);
    MapAccess::cells(map).chunks()->need_all();
    const CellBox bounds = MapAccess::cells(map).bounds();
    if (bounds.low != MapAccess::cell_bounds(map).low || bounds.high != MapAccess::cell_bounds(map).high)
        cooked->file().refuse("has cells that do not fill its bounds");
    return cooked->chunks();
}

} // namespace oncollide
