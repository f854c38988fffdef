// Terrains and occupancy maps.
#include <fmt/format.h>

#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

#include "geometry.hpp"

namespace oncollide::python {

namespace {

/// A height grid: float32 is used directly, other types are converted to float64.
GeometryHandle terrain(py::handle heights, py::handle spacing, py::handle origin, py::handle no_data, py::handle error,
                       py::handle bytes, py::handle falling, py::handle name)
{
    const char* const call = "terrain";
    using Floats = py::array_t<float, py::array::c_style>;
    const bool floats = Floats::check_(heights);
    const py::array array = floats ? py::reinterpret_borrow<py::array>(heights) : doubles(heights, {call, "heights"});
    if (array.ndim() != 2) refuse_value({call, "heights"}, "expected shape (rows, columns), got " + shape_of(array));
    const auto limited = [&](py::ssize_t length) {
        if (length > 0xffffffff) refuse_value({call, "heights"}, "too many rows or columns");
        return static_cast<std::uint32_t>(length);
    };
    TerrainGrid grid;
    grid.rows = limited(array.shape(0)), grid.columns = limited(array.shape(1));
    grid.spacing = vector2(spacing, {call, "spacing"});
    grid.origin = vector3(origin, {call, "origin"});
    if (!no_data.is_none()) grid.no_data = number(no_data, {call, "no_data"});
    grid.error = number(error, {call, "error"});
    grid.bytes = static_cast<int>(whole(bytes, {call, "bytes"}, 8));
    if (!falling.is_none()) {
        using Flags = py::array_t<bool, py::array::c_style>;
        const Place place{call, "falling"};
        if (!py::isinstance<py::array_t<bool>>(falling)) refuse_type(place, "an array of bool", falling);
        const auto flags = Flags::ensure(falling);
        if (!has_shape(flags, {array.shape(0) - 1, array.shape(1) - 1}))
            refuse_value(place, "expected shape (rows - 1, columns - 1), one entry per cell, got " + shape_of(flags));
        grid.falling.assign(flags.data(), flags.data() + flags.size());
    }
    std::string called = text(name, {call, "name"});
    const auto count = static_cast<std::size_t>(array.size());
    return made_without_lock(called, [&]() -> GeometryData {
        const std::string title = name_or(called, call);
        if (floats) return make_terrain(title, grid, std::span(static_cast<const float*>(array.data()), count));
        return make_terrain(title, grid, std::span(static_cast<const double*>(array.data()), count));
    });
}

GeometryHandle terrain_file(py::handle file, py::handle spacing, py::handle origin, py::handle vertical_scale,
                            py::handle no_data, py::handle centre)
{
    const char* const call = "load_terrain";
    const std::string from = path(file, {call, "path"});
    TerrainOptions options;
    if (!spacing.is_none()) options.spacing = vector2(spacing, {call, "spacing"});
    options.origin = vector3(origin, {call, "origin"});
    options.vertical_scale = number(vertical_scale, {call, "vertical_scale"});
    if (!no_data.is_none()) options.no_data = number(no_data, {call, "no_data"});
    options.centre = truth(centre, {call, "centre"});
    return made_without_lock(from, [&] { return load_terrain(from, options); });
}

GeometryHandle occupancy_map(py::handle cells, py::handle resolution, py::handle name)
{
    const char* const call = "occupancy_map";
    const py::array array = whole_numbers(cells, {call, "cells"});
    if (!has_shape(array, {-1, 3}))
        refuse_value({call, "cells"},
                     "expected shape (N, 3), an index along x, y and z for each occupied cell, got " + shape_of(array));
    const double side = number(resolution, {call, "resolution"});
    std::string called = text(name, {call, "name"});
    const auto* at = static_cast<const std::int64_t*>(array.data());
    const auto count = static_cast<std::size_t>(array.shape(0));
    for (std::size_t i = 0; i < 3 * count; ++i)
        if (at[i] < OccupancyMap::lowest_cell || at[i] > OccupancyMap::highest_cell)
            refuse_value({call, "cells"}, fmt::format("cell {}: index {} is out of range; must be from {} to {}", i / 3,
                                                      at[i], OccupancyMap::lowest_cell, OccupancyMap::highest_cell));
    return made_without_lock(called, [&] {
        std::vector<MapCell> occupied;
        occupied.reserve(count);
        for (std::size_t i = 0; i < count; ++i)
            occupied.push_back({static_cast<std::int32_t>(at[3 * i]), static_cast<std::int32_t>(at[3 * i + 1]),
                                static_cast<std::int32_t>(at[3 * i + 2]), 1});
        return make_occupancy_map(name_or(called, call), side, occupied);
    });
}

GeometryHandle map_file(py::handle file, py::handle unknown_is_occupied, py::handle occupancy_threshold)
{
    const char* const call = "load_map";
    const std::string from = path(file, {call, "path"});
    MapOptions options{.unknown_is_occupied = truth(unknown_is_occupied, {call, "unknown_is_occupied"})};
    if (!occupancy_threshold.is_none())
        options.occupancy_threshold = number(occupancy_threshold, {call, "occupancy_threshold"});
    return made_without_lock(from, [&] { return load_octomap(from, options); });
}

} // namespace

void bind_grids(py::module_& m)
{
    using namespace py::literals;
    const auto unnamed = py::arg("name") = py::str("");
    define(m, "terrain", &terrain, R"(A surface over a grid of heights, two triangles per cell; it has no inside.

heights: (rows, columns) metres, at least two of each; heights[r, c] is at origin + (c spacing, r spacing, height).
spacing: metres, one number or (columns', rows'). no_data: heights of this value are holes; may be nan. error: bound on
the error of the heights, metres. bytes: 1, 2, 4 or 8 per height; 0: the smallest size that is exact. falling: bool
(rows - 1, columns - 1), True for a cell that is cut along its other diagonal. Raises Error for an invalid grid.)",
           "heights"_a, "spacing"_a = 1.0, "origin"_a = py::make_tuple(0.0, 0.0, 0.0), "no_data"_a = py::none(),
           "error"_a = 0.0, "bytes"_a = 0, "falling"_a = py::none(), unnamed);
    define(m, "load_terrain", &terrain_file,
           R"(A terrain from a file: PGM, PNG, .npy, and GeoTIFF or DEM if the build has GDAL.

spacing: metres; None: from the file, else 1. vertical_scale: metres per unit of the file's heights. no_data: in the
file's units. centre: moves the centre of its AABB to the origin. Raises Error for a file that is missing or not valid.)",
           "path"_a, "spacing"_a = py::none(), "origin"_a = py::make_tuple(0.0, 0.0, 0.0), "vertical_scale"_a = 1.0,
           "no_data"_a = py::none(), "centre"_a = false);
    define(m, "occupancy_map", &occupancy_map, R"(A map of solid cells; the others are unknown.

cells: (N, 3) whole numbers from -32768 to 32767; cell (i, j, k) is the box from (i, j, k) to (i + 1, j + 1, k + 1)
resolutions. np.argwhere(grid) returns the cells of a dense grid of bools. resolution: metres. Raises Error if no cell
is occupied. Cost: 200 ns per cell.)",
           "cells"_a, "resolution"_a, unnamed);
    define(m, "load_map", &map_file, R"(An occupancy map from an OctoMap file (.bt or .ot).

unknown_is_occupied: unknown cells within the box around the known cells count as occupied. occupancy_threshold: for .ot
files, the least probability of an occupied cell; None: 0.5. Raises Error for a file that is missing or not valid.)",
           "path"_a, "unknown_is_occupied"_a = false, "occupancy_threshold"_a = py::none());

    define(
        m, "hills",
        [](py::handle cells_x, py::handle cells_y, py::handle spacing, py::handle height, py::handle seed) {
            const char* const call = "hills";
            return share("hills", make_hills(static_cast<std::uint32_t>(count(cells_x, call, "cells_x")),
                                             static_cast<std::uint32_t>(count(cells_y, call, "cells_y")),
                                             number(spacing, {call, "spacing"}), number(height, {call, "height"}),
                                             whole(seed, {call, "seed"}, ~std::uint64_t{0})));
        },
        "A terrain over [0, cells_x spacing] x [0, cells_y spacing], metres, at most `height` high; the same for equal "
        "arguments.",
        "cells_x"_a, "cells_y"_a, "spacing"_a, "height"_a, "seed"_a);
}

} // namespace oncollide::python
