// Geometries: from arrays, from files, by their sizes.
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include <oncollide/scenes/files/mesh_file.hpp>
#include <oncollide/scenes/files/terrain_file.hpp>
#include <oncollide/scenes/model/mesh_generators.hpp>

#include "bindings.hpp"
#include "release.hpp"

namespace oncollide::python {

namespace {

GeometryHandle share(std::string name, GeometryData data)
{
    return std::make_shared<const Geometry>(Geometry{std::move(name), std::move(data), {}});
}

/// Of a name that may be missing: what the call makes.
std::string name_or(const std::string& name, const char* call)
{
    return name.empty() ? call : name;
}

template <class Make>
GeometryHandle made_without_lock(std::string name, Make make)
{
    const Released released;
    return share(std::move(name), make());
}

std::vector<Triangle> triangles(py::handle faces, const Place& place)
{
    const py::array array = whole_numbers(faces, place);
    if (!has_shape(array, {-1, 3})) refuse_value(place, "expected shape (F, 3), got " + shape_of(array));
    const auto* at = static_cast<const std::int64_t*>(array.data()); // what is too large without a sign is negative
    std::vector<Triangle> made(static_cast<std::size_t>(array.shape(0)));
    for (std::size_t i = 0; i < made.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::int64_t index = at[3 * i + k];
            if (index < 0 || index > std::int64_t{0xffffffff})
                refuse_value(place, fmt::format("face {} uses vertex {}; indices begin at 0", i, index));
            made[i][k] = static_cast<std::uint32_t>(index);
        }
    return made;
}

GeometryHandle mesh(py::handle vertices, py::handle faces, py::handle name)
{
    std::vector<Eigen::Vector3d> corners = points(vertices, {"mesh", "vertices"});
    std::vector<Triangle> all = triangles(faces, {"mesh", "faces"});
    std::string called = text(name, {"mesh", "name"});
    return made_without_lock(called,
                             [&] { return make_mesh(name_or(called, "mesh"), std::move(corners), std::move(all)); });
}

GeometryHandle mesh_file(py::handle file, py::handle scale, py::handle fit_diagonal, py::handle centre)
{
    const char* const call = "load_mesh";
    const std::string from = path(file, {call, "path"});
    const MeshOptions options{.scale = number(scale, {call, "scale"}),
                              .fit_diagonal = number(fit_diagonal, {call, "fit_diagonal"}),
                              .centre = truth(centre, {call, "centre"})};
    return made_without_lock(from, [&] { return load_mesh(from, options); });
}

GeometryHandle shape(const char* call, Shape made, py::handle name)
{
    std::string called = text(name, {call, "name"});
    check_shape(name_or(called, call), made);
    return share(std::move(called), std::move(made));
}

/// A height grid: float32 is taken as it is, all else as float64.
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
            refuse_value(place, "expected shape (rows - 1, columns - 1), one entry a cell, got " + shape_of(flags));
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
        if (at[i] < CellTree::lowest || at[i] >= CellTree::lowest + CellTree::side)
            refuse_value({call, "cells"}, fmt::format("cell {}: index {} is out of range; must be from {} to {}", i / 3,
                                                      at[i], CellTree::lowest, CellTree::lowest + CellTree::side - 1));
    return made_without_lock(called, [&] {
        CellTree tree;
        for (std::size_t i = 0; i < count; ++i) {
            const MapCell cell{static_cast<std::int32_t>(at[3 * i]), static_cast<std::int32_t>(at[3 * i + 1]),
                               static_cast<std::int32_t>(at[3 * i + 2]), 1};
            tree.set(CellBox(cell), CellState::occupied);
        }
        return OccupancyMap(name_or(called, call), std::move(tree), side);
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

int count(py::handle value, const char* call, const char* argument)
{
    return static_cast<int>(whole(value, {call, argument}, 1u << 30));
}

const char* kind_of(const Geometry& geometry)
{
    if (std::holds_alternative<Mesh>(geometry.data)) return "mesh";
    if (std::holds_alternative<OccupancyMap>(geometry.data)) return "map";
    if (std::holds_alternative<Terrain>(geometry.data)) return "terrain";
    constexpr const char* shapes[] = {"sphere",      "box",       "capsule", "cylinder",
                                      "convex_hull", "ellipsoid", "cone",    "half_space"};
    return shapes[std::get<Shape>(geometry.data).index()];
}

const Mesh& mesh_in(const Geometry& geometry, const char* property)
{
    if (const auto* found = std::get_if<Mesh>(&geometry.data)) return *found;
    throw py::attribute_error(
        fmt::format("Geometry.{}: only a mesh has it; this is a {}", property, kind_of(geometry)));
}

/// Rows of three numbers, which the geometry keeps; not to be written to.
template <class T>
py::array rows(py::object owner, const std::vector<std::array<T, 3>>& items)
{
    py::array_t<T> made({static_cast<py::ssize_t>(items.size()), py::ssize_t{3}},
                        items.empty() ? nullptr : items[0].data(), owner);
    made.attr("flags").attr("writeable") = false;
    return made;
}

} // namespace

GeometryHandle geometry(py::handle value, const Place& place)
{
    if (!py::isinstance<Geometry>(value))
        refuse_type(place, "a Geometry, as oncollide.mesh(), load_mesh(), sphere() and others make it", value);
    return py::cast<std::shared_ptr<Geometry>>(value);
}

void bind_geometry(py::module_& m)
{
    using namespace py::literals;
    const auto unnamed = py::arg("name") = py::str("");

    py::class_<Geometry, std::shared_ptr<Geometry>>(m, "Geometry", R"(What a body is made of, in its own frame, metres.

Made by mesh(), load_mesh(), sphere(), terrain(), load_map() and others. It never changes, keeps no array that it was
made from, and is shared, not copied, by every World and Queries that it is given to.)")
        .def_property_readonly(
            "name", [](const Geometry& g) { return g.name; },
            "What messages call it: the name or the path that it was made with (str).")
        .def_property_readonly(
            "kind", [](const Geometry& g) { return kind_of(g); },
            "'mesh', 'sphere', 'box', 'capsule', 'cylinder', 'convex_hull', 'ellipsoid', 'cone', "
            "'half_space', 'map' or 'terrain'.")
        .def_property_readonly(
            "bounds",
            [](const Geometry& g) {
                const Aabb box = bounds_of(g);
                py::array_t<double> made({2, 3});
                for (py::ssize_t k = 0; k < 3; ++k)
                    made.mutable_at(0, k) = box.min[k], made.mutable_at(1, k) = box.max[k];
                return made;
            },
            "The box around it in its own frame, metres: least and greatest corner, float64 (2, 3).")
        .def_property_readonly(
            "vertices",
            [](py::object self) {
                const Mesh& mesh = mesh_in(self.cast<const Geometry&>(), "vertices");
                py::array_t<double> made({static_cast<py::ssize_t>(mesh.vertices.size()), py::ssize_t{3}},
                                         mesh.vertices.data()->data(), self);
                made.attr("flags").attr("writeable") = false;
                return made;
            },
            "Of a mesh: float64 (V, 3), metres; a view that cannot be written to.")
        .def_property_readonly(
            "faces",
            [](py::object self) {
                return rows<std::uint32_t>(self, mesh_in(self.cast<const Geometry&>(), "faces").triangles);
            },
            "Of a mesh: uint32 (F, 3); a view that cannot be written to.")
        .def_property_readonly(
            "closed",
            [](const Geometry& g) {
                const auto* mesh = std::get_if<Mesh>(&g.data);
                return mesh ? is_closed(*mesh) : !std::holds_alternative<Terrain>(g.data);
            },
            "Does it have an inside? Of a mesh: is every edge shared by two triangles that run along it in opposite "
            "directions? Cost: O(F log F).")
        .def("__repr__", [](const Geometry& g) {
            std::string text = fmt::format("<oncollide.Geometry: {}", kind_of(g));
            if (!g.name.empty()) text += fmt::format(" '{}'", printable(g.name));
            if (const auto* mesh = std::get_if<Mesh>(&g.data))
                text += fmt::format(", {} vertices, {} faces", mesh->vertices.size(), mesh->triangles.size());
            return text + ">";
        });

    m.def("mesh", &mesh, "vertices"_a, "faces"_a, unnamed, R"(mesh(vertices, faces, name="")
--

A triangle mesh from arrays, which are copied.

vertices: (V, 3) numbers, metres, finite and at most 1e15. faces: (F, 3) whole numbers, rows of `vertices`, F >= 1.
name: what messages call it. Raises TypeError or ValueError for arrays of another type or shape, Error for an index out
of range or a vertex that is not finite. Cost: 10 ns a triangle.)");
    m.def("load_mesh", &mesh_file, "path"_a, "scale"_a = 1.0, "fit_diagonal"_a = 0.0, "centre"_a = false,
          R"(load_mesh(path, scale=1.0, fit_diagonal=0.0, centre=False)
--

A mesh from an OBJ, STL, PLY, OFF, glTF or GLB file.

scale: metres for each unit of the file. fit_diagonal: if above 0, scaled again so that the diagonal of the box around it
is this long, metres. centre: moves the middle of that box to the origin. Raises Error for a file that is missing or not
valid.)");
    m.def(
        "sphere",
        [](py::handle radius, py::handle name) {
            return shape("sphere", Sphere{number(radius, {"sphere", "radius"})}, name);
        },
        "radius"_a, unnamed, R"(sphere(radius, name="")
--

A solid ball around the origin. radius: metres, > 0.)");
    m.def(
        "box",
        [](py::handle half, py::handle name) {
            return shape("box", Box{vector3(half, {"box", "half_extents"})}, name);
        },
        "half_extents"_a, unnamed, R"(box(half_extents, name="")
--

A solid box around the origin. half_extents: (3,) metres, half of each side, > 0.)");
    const auto along_z = [&](const char* call, auto make, const char* text) {
        m.def(
            call,
            [call, make](py::handle radius, py::handle length, py::handle name) {
                return shape(call, make(number(radius, {call, "radius"}), number(length, {call, "length"})), name);
            },
            "radius"_a, "length"_a, unnamed, text);
    };
    along_z(
        "capsule",
        [](double r, double l) {
            return Shape(Capsule{r, l});
        },
        R"(capsule(radius, length, name="")
--

A solid capsule along z, its middle at the origin. radius: metres, > 0. length: of the cylinder, without the caps, >= 0.)");
    along_z(
        "cylinder",
        [](double r, double l) {
            return Shape(Cylinder{r, l});
        },
        R"(cylinder(radius, length, name="")
--

A solid cylinder along z, its middle at the origin. radius, length: metres, > 0.)");
    along_z(
        "cone",
        [](double r, double l) {
            return Shape(Cone{r, l});
        },
        R"(cone(radius, length, name="")
--

A solid cone along z: the base at z = -length / 2, the apex at length / 2. radius, length: metres, > 0.)");
    m.def(
        "ellipsoid",
        [](py::handle semi_axes, py::handle name) {
            return shape("ellipsoid", Ellipsoid{vector3(semi_axes, {"ellipsoid", "semi_axes"})}, name);
        },
        "semi_axes"_a, unnamed, R"(ellipsoid(semi_axes, name="")
--

A solid ellipsoid around the origin. semi_axes: (3,) metres along x, y and z, > 0.)");
    m.def(
        "convex_hull",
        [](py::handle corners, py::handle name) {
            return shape("convex_hull", ConvexHull{points(corners, {"convex_hull", "points"})}, name);
        },
        "points"_a, unnamed, R"(convex_hull(points, name="")
--

The solid convex hull of points: (N, 3) metres, at least four, not in one plane.)");
    m.def(
        "half_space", [](py::handle name) { return shape("half_space", HalfSpace{}, name); }, unnamed,
        R"(half_space(name="")
--

All points with z <= 0 in its own frame: a floor without end.)");
    m.def(
        "terrain", &terrain, "heights"_a, "spacing"_a = 1.0, "origin"_a = py::make_tuple(0.0, 0.0, 0.0),
        "no_data"_a = py::none(), "error"_a = 0.0, "bytes"_a = 0, "falling"_a = py::none(), unnamed,
        R"(terrain(heights, spacing=1.0, origin=(0.0, 0.0, 0.0), no_data=None, error=0.0, bytes=0, falling=None, name="")
--

A surface over a grid of heights, two triangles a cell; without an inside.

heights: (rows, columns) metres, at least two of each; heights[r, c] is at origin + (c spacing, r spacing, height).
spacing: metres, one number or (columns', rows'). no_data: heights that are holes; may be nan. error: by how much heights
may be off, metres. bytes: for each height 1, 2, 4 or 8; 0: the fewest that are exact. falling: bool (rows - 1,
columns - 1), True for a cell that is cut along its other diagonal. Raises Error for a grid that is no terrain.)");
    m.def("load_terrain", &terrain_file, "path"_a, "spacing"_a = py::none(), "origin"_a = py::make_tuple(0.0, 0.0, 0.0),
          "vertical_scale"_a = 1.0, "no_data"_a = py::none(), "centre"_a = false,
          R"(load_terrain(path, spacing=None, origin=(0.0, 0.0, 0.0), vertical_scale=1.0, no_data=None, centre=False)
--

A terrain from a file: PGM, PNG, .npy, and GeoTIFF or DEM where the build has GDAL.

spacing: metres; None: what the file says, else 1. vertical_scale: metres for each unit of the file's heights. no_data:
in the file's units. centre: moves the middle of the box around it to the origin. Raises Error for a file that is missing
or not valid.)");
    m.def("occupancy_map", &occupancy_map, "cells"_a, "resolution"_a, unnamed,
          R"(occupancy_map(cells, resolution, name="")
--

A map of solid cells; the others are unknown.

cells: (N, 3) whole numbers from -32768 to 32767; cell (i, j, k) is the box from (i, j, k) to (i + 1, j + 1, k + 1)
resolutions. np.argwhere(grid) gives those of a dense grid of bools. resolution: metres. Raises Error where no cell is
occupied. Cost: 200 ns a cell.)");
    m.def("load_map", &map_file, "path"_a, "unknown_is_occupied"_a = false, "occupancy_threshold"_a = py::none(),
          R"(load_map(path, unknown_is_occupied=False, occupancy_threshold=None)
--

An OctoMap environment from a .bt or .ot file.

unknown_is_occupied: cells that nothing is known of, within the box around the known ones, count as occupied.
occupancy_threshold: for .ot files, the probability from which a cell is occupied; None: 0.5. Raises Error for a file
that is missing or not valid.)");

    m.def(
        "box_mesh",
        [](py::handle half) {
            return share("box", make_box_mesh(vector3(half, {"box_mesh", "half_extents"})));
        },
        "half_extents"_a, R"(box_mesh(half_extents)
--

A closed mesh of 12 triangles. half_extents: (3,) metres.)");
    m.def(
        "sphere_mesh",
        [](py::handle radius, py::handle triangles) {
            return share("sphere", make_sphere_mesh(number(radius, {"sphere_mesh", "radius"}),
                                                    count(triangles, "sphere_mesh", "triangles")));
        },
        "radius"_a, "triangles"_a, R"(sphere_mesh(radius, triangles)
--

A closed mesh with corners on a sphere. radius: metres. triangles: how many, or one less where that is odd.)");
    m.def(
        "torus_mesh",
        [](py::handle major, py::handle minor, py::handle triangles) {
            const char* const call = "torus_mesh";
            return share("torus", make_torus_mesh(number(major, {call, "major"}), number(minor, {call, "minor"}),
                                                  count(triangles, call, "triangles")));
        },
        "major"_a, "minor"_a, "triangles"_a, R"(torus_mesh(major, minor, triangles)
--

A closed ring around z. major, minor: radii of the ring and of its tube, metres. triangles: at least 18.)");
    m.def(
        "torus_knot_mesh",
        [](py::handle p, py::handle q, py::handle major, py::handle minor, py::handle tube, py::handle triangles) {
            const char* const call = "torus_knot_mesh";
            return share("torus knot",
                         make_torus_knot_mesh(count(p, call, "p"), count(q, call, "q"), number(major, {call, "major"}),
                                              number(minor, {call, "minor"}), number(tube, {call, "tube"}),
                                              count(triangles, call, "triangles")));
        },
        "p"_a, "q"_a, "major"_a, "minor"_a, "tube"_a, "triangles"_a,
        R"(torus_knot_mesh(p, q, major, minor, tube, triangles)
--

A closed tube along a (p, q) torus knot; p and q coprime. major, minor, tube: radii, metres. triangles: at least 18.)");
    m.def(
        "hills",
        [](py::handle cells_x, py::handle cells_y, py::handle spacing, py::handle height, py::handle seed) {
            const char* const call = "hills";
            return share("hills", make_hills(static_cast<std::uint32_t>(count(cells_x, call, "cells_x")),
                                             static_cast<std::uint32_t>(count(cells_y, call, "cells_y")),
                                             number(spacing, {call, "spacing"}), number(height, {call, "height"}),
                                             whole(seed, {call, "seed"}, ~std::uint64_t{0})));
        },
        "cells_x"_a, "cells_y"_a, "spacing"_a, "height"_a, "seed"_a,
        R"(hills(cells_x, cells_y, spacing, height, seed)
--

A terrain over [0, cells_x spacing] x [0, cells_y spacing], metres, at most `height` high; the same for equal arguments.)");
}

} // namespace oncollide::python
