#include <oncollide/scenes/files/geometry_file.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/scenes/cooked/cooked_mesh.hpp>
#include <oncollide/scenes/cooked/cooked_terrain.hpp>
#include <oncollide/scenes/files/common/npy.hpp>
#include <oncollide/scenes/files/common/sample_type.hpp>
#include <oncollide/scenes/files/terrain/height_raster.hpp>

namespace oncollide {

namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t largest_file = std::uintmax_t(8) << 30;

HeightRaster read_raw(const std::string& name, const TerrainOptions& options, std::string_view bytes)
{
    if (options.type.empty() || options.columns == 0 || options.rows == 0)
        throw Error(ErrorKind::usage, name + ": a raw array needs its columns, rows and type");
    const SampleType type = sample_type(name, options.type);
    check_size(name, options.columns, options.rows, type.size, bytes.size());
    return {options.columns, options.rows, decoded(type, bytes), type.kind != 'f'};
}

/// The first five need no other library.
const std::vector<std::string> extensions{"pgm",  "png", "npy", "raw", "bin", "tif",
                                          "tiff", "dem", "asc", "hgt", "vrt", "img"};

HeightRaster read_raster(const fs::path& path, const TerrainOptions& options)
{
    const std::string name = path.string();
    std::string ending = lower_extension(path);
    ending.erase(0, 1);
    const auto known = std::ranges::find(extensions, ending);
    if (known == extensions.end())
        refuse(name,
               fmt::format("unknown kind of terrain file '.{}'; known are {}", ending, fmt::join(extensions, ", ")));
    if (known - extensions.begin() >= 5) return read_with_gdal(path);
    const FileBytes bytes = read_large_file(path, largest_file);
    if (ending == "pgm") return read_pgm(name, bytes);
    if (ending == "png") return read_grey_png(name, bytes);
    return ending == "npy" ? read_npy(name, bytes) : read_raw(name, options, bytes);
}

std::vector<bool> read_diagonals(const fs::path& path, const HeightRaster& heights)
{
    const HeightRaster cells = read_npy(path.string(), read_file(path, largest_file));
    if (cells.columns + 1 != heights.columns || cells.rows + 1 != heights.rows)
        refuse(path.string(), fmt::format("diagonals of {} x {} cells, but there are {} x {} heights", cells.columns,
                                          cells.rows, heights.columns, heights.rows));
    std::vector<bool> falling;
    for (const double cell : cells.heights) falling.push_back(cell != 0);
    return falling;
}

void write_npy(const fs::path& path, std::string_view type, std::uint32_t rows, std::uint32_t columns, auto write_rows)
{
    OutputFile file(path);
    file.write(npy_header(type, std::array<std::uint64_t, 2>{rows, columns}));
    write_rows(file);
    file.commit();
}

} // namespace

const std::vector<std::string>& terrain_extensions()
{
    return extensions;
}

Terrain load_terrain(const fs::path& path, const TerrainOptions& options)
{
    const std::string name = path.string();
    if (is_cooked(path)) {
        if (!(options == TerrainOptions{}))
            throw Error(ErrorKind::usage, name + ": the grid of a cooked terrain is in the file; give its options to "
                                                 "'oncollide cook'");
        return CookedTerrainChunks::terrain(std::make_shared<const CookedTerrain>(path));
    }
    if (!(options.vertical_scale > 0 && options.vertical_scale <= 1e15))
        throw Error(ErrorKind::usage, fmt::format("{}: a vertical scale of {}; must be above 0 and at most 1e15", name,
                                                  options.vertical_scale));
    if (options.spacing && !((options.spacing->array() > 0).all() && (options.spacing->array() <= 1e15).all()))
        throw Error(ErrorKind::usage, fmt::format("{}: a spacing of {} and {}; must be above 0 and at most 1e15", name,
                                                  options.spacing->x(), options.spacing->y()));
    if (options.no_data && std::isinf(*options.no_data))
        throw Error(ErrorKind::usage,
                    fmt::format("{}: a no-data value of {}; must be a finite number or nan", name, *options.no_data));
    HeightRaster raster = read_raster(path, options);
    TerrainGrid grid{.columns = raster.columns, .rows = raster.rows};
    grid.spacing = options.spacing.value_or(raster.spacing.value_or(Eigen::Vector2d(1, 1)));
    grid.origin = options.origin, grid.bytes = options.bytes, grid.error = options.error;
    grid.diagonal = options.diagonal;
    if (!options.diagonals.empty()) grid.falling = read_diagonals(options.diagonals, raster);
    if (raster.whole) grid.unit = options.vertical_scale;
    if (const auto no_data = options.no_data ? options.no_data : raster.no_data) {
        // Marks holes before scaling, so that no scaled height equals the no-data value.
        grid.no_data = std::numeric_limits<double>::quiet_NaN();
        for (double& height : raster.heights) {
            if (std::isnan(height) && !std::isnan(*no_data))
                refuse(name, fmt::format("a height is not a number, and the no-data value is {}", *no_data));
            if (height == *no_data) height = *grid.no_data;
        }
    }
    for (double& height : raster.heights) height *= options.vertical_scale;
    Terrain terrain = make_terrain(name, grid, raster.heights);
    return options.centre ? centred(std::move(terrain)) : terrain;
}

std::string diagonals_file(const std::string& path)
{
    return path_of(path).replace_extension(".diagonals.npy").string();
}

void save_terrain(const Terrain& terrain, const fs::path& path)
{
    write_npy(path, "<f8", terrain.rows(), terrain.columns(), [&](OutputFile& file) {
        for (std::uint32_t r = 0; r < terrain.rows(); ++r)
            for (std::uint32_t c = 0; c < terrain.columns(); ++c) {
                auto bits = std::bit_cast<std::uint64_t>(terrain.height(c, r));
                char bytes[8];
                for (char& byte : bytes) byte = static_cast<char>(bits & 0xff), bits >>= 8;
                file.write({bytes, 8});
            }
    });
    if (!terrain.mixed_diagonals()) return;
    write_npy(path_of(diagonals_file(path.string())), "|u1", terrain.cells_y(), terrain.cells_x(),
              [&](OutputFile& file) {
                  for (std::uint32_t y = 0; y < terrain.cells_y(); ++y)
                      for (std::uint32_t x = 0; x < terrain.cells_x(); ++x)
                          file.write(terrain.diagonal(x, y) == CellDiagonal::falling ? std::string_view("\1", 1)
                                                                                     : std::string_view("\0", 1));
              });
}

} // namespace oncollide
