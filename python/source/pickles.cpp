// Geometries as tuples, for pickles.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>

#include <oncollide/scenes/cooked/cooked_map.hpp>
#include <oncollide/scenes/cooked/cooked_mesh.hpp>
#include <oncollide/scenes/cooked/cooked_terrain.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>
#include <oncollide/scenes/model/map/map_access.hpp>

#include "geometry.hpp"

namespace oncollide::python {

namespace {

using Eigen::Vector3d;
using Doubles = std::vector<double>;

Doubles numbers_of(const Shape& shape)
{
    const auto three = [](const Vector3d& v) { return Doubles{v.x(), v.y(), v.z()}; };
    if (const auto* sphere = std::get_if<Sphere>(&shape)) return {sphere->radius};
    if (const auto* box = std::get_if<Box>(&shape)) return three(box->half);
    if (const auto* capsule = std::get_if<Capsule>(&shape)) return {capsule->radius, capsule->length};
    if (const auto* cylinder = std::get_if<Cylinder>(&shape)) return {cylinder->radius, cylinder->length};
    if (const auto* cone = std::get_if<Cone>(&shape)) return {cone->radius, cone->length};
    if (const auto* ellipsoid = std::get_if<Ellipsoid>(&shape)) return three(ellipsoid->semi_axes);
    Doubles points;
    if (const auto* hull = std::get_if<ConvexHull>(&shape))
        for (const Vector3d& p : hull->points) points.insert(points.end(), p.begin(), p.end());
    return points;
}

Shape shape_from(std::size_t kind, Doubles n)
{
    const std::size_t count = n.size();
    n.resize(std::max<std::size_t>(count, 3));
    ConvexHull hull;
    for (std::size_t i = 0; i + 3 <= count; i += 3) hull.points.emplace_back(n[i], n[i + 1], n[i + 2]);
    const Vector3d three(n[0], n[1], n[2]);
    const Shape shapes[] = {Sphere{n[0]},    Box{three},       Capsule{n[0], n[1]}, Cylinder{n[0], n[1]},
                            std::move(hull), Ellipsoid{three}, Cone{n[0], n[1]},    HalfSpace{}};
    if (kind >= std::size(shapes)) throw py::value_error("there is no shape of this number");
    return shapes[kind];
}

py::tuple parts_of(const OccupancyMap& map)
{
    std::vector<MapCell> occupied, free;
    const CellTree& cells = MapAccess::cells(map);
    cells.each_leaf([&](const MapCell& cell, CellState state) {
        (state == CellState::occupied ? occupied : free).push_back(cell);
    });
    return py::make_tuple(map.resolution(), cells.unknown_is_solid(), bytes_of(std::span<const MapCell>(occupied)),
                          bytes_of(std::span<const MapCell>(free)));
}

OccupancyMap map_of(const std::string& name, const py::tuple& parts)
{
    return make_occupancy_map(name, parts[0].cast<double>(), values_in<MapCell>(parts[2]), values_in<MapCell>(parts[3]),
                              parts[1].cast<bool>());
}

constexpr double no_holes = std::numeric_limits<double>::infinity(); ///< in the place of no_data

/// The stored heights, which are exact in double.
py::tuple parts_of(const Terrain& terrain)
{
    const CookedTerrainRecord record = CookedTerrain::record_of(terrain);
    Doubles heights(std::size_t{terrain.columns()} * terrain.rows());
    for (std::uint32_t row = 0; row < terrain.rows(); ++row)
        terrain.read_row(row, 0.0, heights.data() + std::size_t{row} * terrain.columns());
    std::vector<std::uint8_t> falling;
    if (terrain.mixed_diagonals())
        for (std::uint32_t y = 0; y < terrain.cells_y(); ++y)
            for (std::uint32_t x = 0; x < terrain.cells_x(); ++x)
                falling.push_back(terrain.diagonal(x, y) == CellDiagonal::falling);
    std::optional<double> no_data = terrain.no_data();
    if (no_data && std::ranges::count(heights, *no_data)) // an inexact height is stored so
        no_data = std::numeric_limits<double>::quiet_NaN();
    if (no_data)
        std::ranges::replace_if(
            heights, [](double height) { return std::isnan(height); }, *no_data);
    const Doubles numbers{terrain.spacing().x(), terrain.spacing().y(),     terrain.origin().x(),
                          terrain.origin().y(),  terrain.origin().z(),      terrain.error(),
                          record.unit,           no_data.value_or(no_holes)};
    return py::make_tuple(terrain.columns(), terrain.rows(), bytes_of(std::span<const double>(numbers)),
                          terrain.diagonal(0, 0) == CellDiagonal::falling,
                          bytes_of(std::span<const std::uint8_t>(falling)), bytes_of(std::span<const double>(heights)));
}

Terrain terrain_of(const std::string& name, const py::tuple& parts)
{
    Doubles n = values_in<double>(parts[2]);
    n.resize(std::max<std::size_t>(n.size(), 7)),
        n.resize(8, std::numeric_limits<double>::quiet_NaN()); // as older pickles mean it
    TerrainGrid grid;
    grid.columns = parts[0].cast<std::uint32_t>(), grid.rows = parts[1].cast<std::uint32_t>();
    grid.spacing = {n[0], n[1]}, grid.origin = {n[2], n[3], n[4]}, grid.error = n[5], grid.unit = n[6];
    if (n[7] != no_holes) grid.no_data = n[7];
    grid.diagonal = parts[3].cast<bool>() ? CellDiagonal::falling : CellDiagonal::rising;
    const std::vector<std::uint8_t> falling = values_in<std::uint8_t>(parts[4]);
    grid.falling.assign(falling.begin(), falling.end());
    return make_terrain(name, grid, values_in<double>(parts[5]));
}

/// The file that the geometry stays in; null: it is in memory.
const CookedFile* file_of(const GeometryData& data)
{
    if (const auto* mesh = std::get_if<std::shared_ptr<const CookedMesh>>(&data)) return &(*mesh)->file();
    if (const auto* map = std::get_if<OccupancyMap>(&data))
        if (const CookedMapChunks* chunks = cooked_chunks(*map)) return &chunks->cooked()->file();
    if (const auto* terrain = std::get_if<Terrain>(&data))
        if (const CookedTerrainChunks* chunks = cooked_chunks(*terrain)) return &chunks->cooked()->file();
    return nullptr;
}

} // namespace

py::tuple state_of(const Geometry& geometry)
{
    const py::bytes name(geometry.name); // a path may contain bytes that are not UTF-8
    if (const CookedFile* const file = file_of(geometry.data))
        return py::make_tuple(name, "file", py::bytes(file->path().string()));
    if (const auto* mesh = std::get_if<Mesh>(&geometry.data))
        return py::make_tuple(name, "mesh",
                              py::make_tuple(bytes_of(std::span<const Vector3d>(mesh->vertices)),
                                             bytes_of(std::span<const Triangle>(mesh->triangles))));
    if (const auto* map = std::get_if<OccupancyMap>(&geometry.data)) return py::make_tuple(name, "map", parts_of(*map));
    if (const auto* terrain = std::get_if<Terrain>(&geometry.data))
        return py::make_tuple(name, "terrain", parts_of(*terrain));
    const Shape& shape = std::get<Shape>(geometry.data);
    const Doubles numbers = numbers_of(shape);
    return py::make_tuple(name, "shape", py::make_tuple(shape.index(), bytes_of(std::span<const double>(numbers))));
}

GeometryHandle geometry_from(const py::tuple& state)
{
    std::string name = state[0].cast<std::string>();
    const auto kind = state[1].cast<std::string>();
    if (kind == "file") return share(std::move(name), std::move(load_geometry(state[2].cast<std::string>())->data));
    const auto parts = state[2].cast<py::tuple>();
    const std::string title = name_or(name, "pickle");
    if (kind == "mesh")
        return share(std::move(name), make_mesh(title, values_in<Vector3d>(parts[0]), values_in<Triangle>(parts[1])));
    if (kind == "map") return share(std::move(name), map_of(title, parts));
    if (kind == "terrain") return share(std::move(name), terrain_of(title, parts));
    if (kind != "shape") throw py::value_error("there is no geometry of the kind " + kind);
    Shape shape = shape_from(parts[0].cast<std::size_t>(), values_in<double>(parts[1]));
    check_shape(title, shape);
    return share(std::move(name), std::move(shape));
}

} // namespace oncollide::python
