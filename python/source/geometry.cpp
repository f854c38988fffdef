// Geometry, and meshes.
#include "geometry.hpp"

#include <utility>

#include <fmt/format.h>

#include <oncollide/base/text/printable.hpp>
#include <oncollide/narrowphase/cook_mesh.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/cooked/cooked_mesh.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

namespace oncollide::python {

namespace {

std::vector<Triangle> triangles(py::handle faces, const Place& place)
{
    const py::array array = whole_numbers(faces, place);
    if (!has_shape(array, {-1, 3})) refuse_value(place, "expected shape (F, 3), got " + shape_of(array));
    const auto* at = static_cast<const std::int64_t*>(array.data()); // unsigned numbers that are too large become
                                                                     // negative
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

using CookedHandle = std::shared_ptr<const CookedMesh>;

thread_local std::vector<std::string> file_warnings; // noted without the lock of the interpreter

GeometryHandle mesh_file(py::handle file, py::handle scale, py::handle fit_diagonal, py::handle centre,
                         py::handle on_demand)
{
    const char* const call = "load_mesh";
    const std::string from = path(file, {call, "path"});
    const MeshOptions options{.scale = number(scale, {call, "scale"}),
                              .fit_diagonal = number(fit_diagonal, {call, "fit_diagonal"}),
                              .centre = truth(centre, {call, "centre"})};
    if (!truth(on_demand, {call, "on_demand"}))
        return made_without_lock(from, [&] { return load_mesh(from, options); });
    if (options.scale != 1 || options.fit_diagonal != 0 || options.centre)
        refuse_value({call, "on_demand"}, "scale, fit_diagonal and centre cannot change a mesh that stays in its file");
    return made_without_lock(from, [&] { return std::make_shared<const CookedMesh>(from); });
}

GeometryHandle any_file(py::handle file)
{
    const std::string from = path(file, {"load", "path"});
    return made_without_lock(from, [&] { return std::move(load_geometry(from)->data); });
}

void cook(py::handle made, py::handle file)
{
    const GeometryHandle shared = geometry(made, {"cook", "geometry"});
    const std::string to = path(file, {"cook", "path"});
    if (!is_cooked(to)) refuse_value({"cook", "path"}, "the name must end in .cooked");
    const Released released;
    if (const auto* mesh = std::get_if<Mesh>(&shared->data))
        cook_mesh(*mesh, to);
    else if (const auto* map = std::get_if<OccupancyMap>(&shared->data))
        cook_map(*map, to);
    else if (const auto* terrain = std::get_if<Terrain>(&shared->data))
        cook_terrain(*terrain, to);
    else
        throw Error(ErrorKind::usage, "cook: only a mesh in memory, a map or a terrain can be cooked");
}

const char* kind_of(const Geometry& geometry)
{
    if (std::holds_alternative<Mesh>(geometry.data) || std::holds_alternative<CookedHandle>(geometry.data))
        return "mesh";
    if (std::holds_alternative<OccupancyMap>(geometry.data)) return "map";
    if (std::holds_alternative<Terrain>(geometry.data)) return "terrain";
    constexpr const char* shapes[] = {"sphere",      "box",       "capsule", "cylinder",
                                      "convex_hull", "ellipsoid", "cone",    "half_space"};
    return shapes[std::get<Shape>(geometry.data).index()];
}

const Mesh& mesh_in(const Geometry& geometry, const char* property)
{
    if (const auto* found = std::get_if<Mesh>(&geometry.data)) return *found;
    if (std::holds_alternative<CookedHandle>(geometry.data))
        throw py::attribute_error(fmt::format("Geometry.{}: this mesh stays in its file; load_mesh() without on_demand "
                                              "has it",
                                              property));
    throw py::attribute_error(
        fmt::format("Geometry.{}: only a mesh has it; this is a {}", property, kind_of(geometry)));
}

/// Rows of three numbers, as a read-only view; the geometry stays alive.
template <class T>
py::array rows(py::object owner, const std::vector<std::array<T, 3>>& items)
{
    py::array_t<T> made({static_cast<py::ssize_t>(items.size()), py::ssize_t{3}},
                        items.empty() ? nullptr : items[0].data(), owner);
    made.attr("flags").attr("writeable") = false;
    return made;
}

} // namespace

void emit_file_warnings()
{
    for (const std::string& line : std::exchange(file_warnings, {}))
        if (PyErr_WarnEx(PyExc_UserWarning, line.c_str(), 1) != 0) throw py::error_already_set();
}

GeometryHandle geometry(py::handle value, const Place& place)
{
    if (!py::isinstance<Geometry>(value))
        refuse_type(place, "a Geometry, as oncollide.mesh(), load_mesh(), sphere() and others make it", value);
    (void)py::cast<const Geometry&>(value); // refuses an object without one
    return py::cast<std::shared_ptr<Geometry>>(value);
}

void bind_geometry(py::module_& m)
{
    using namespace py::literals;
    on_file_warning([](const std::string& line) { file_warnings.push_back(line); });
    const auto unnamed = py::arg("name") = py::str("");
    py::class_<Geometry, std::shared_ptr<Geometry>>(m, "Geometry", R"(The geometry of a body, in its own frame, metres.

Made by mesh(), load_mesh(), sphere(), terrain(), load_map() and others. It never changes, copies the arrays that it is
made from, and is shared, not copied, by every World that uses it. It can be pickled, for processes that work on one
scene: a mesh, a shape, a map or a terrain by its data, a geometry in a cooked file by the file's path.)")
        .def_property_readonly(
            "name",
            [](const Geometry& g) { // a path may contain bytes that are not UTF-8
                return py::reinterpret_steal<py::object>(
                    PyUnicode_DecodeFSDefaultAndSize(g.name.data(), static_cast<py::ssize_t>(g.name.size())));
            },
            "Its name in messages: the name or the path that it was made with (str).")
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
            "Its AABB in its own frame, metres: least and greatest corner, float64 (2, 3).")
        .def_property_readonly(
            "vertices",
            [](py::object self) {
                const Mesh& mesh = mesh_in(self.cast<const Geometry&>(), "vertices");
                py::array_t<double> made({static_cast<py::ssize_t>(mesh.vertices.size()), py::ssize_t{3}},
                                         mesh.vertices.data()->data(), self);
                made.attr("flags").attr("writeable") = false;
                return made;
            },
            "Only meshes: float64 (V, 3), metres; a read-only view.")
        .def_property_readonly(
            "faces",
            [](py::object self) {
                return rows<std::uint32_t>(self, mesh_in(self.cast<const Geometry&>(), "faces").triangles);
            },
            "Only meshes: uint32 (F, 3); a read-only view.")
        .def_property_readonly(
            "closed",
            [](const Geometry& g) {
                if (std::holds_alternative<CookedHandle>(g.data)) return is_closed(mesh_in(g, "closed"));
                const auto* mesh = std::get_if<Mesh>(&g.data);
                return mesh ? is_closed(*mesh) : !std::holds_alternative<Terrain>(g.data);
            },
            "True if it has an inside. A mesh: if every edge is shared by two triangles that traverse it in opposite "
            "directions. Cost: O(F log F).")
        .def("__repr__",
             [](const Geometry& g) {
                 std::string text = fmt::format("<oncollide.Geometry: {}", kind_of(g));
                 if (!g.name.empty()) text += fmt::format(" '{}'", printable(g.name));
                 if (const auto* mesh = std::get_if<Mesh>(&g.data))
                     text += fmt::format(", {} vertices, {} faces", mesh->vertices.size(), mesh->triangles.size());
                 if (const auto* cooked = std::get_if<CookedHandle>(&g.data))
                     text += fmt::format(", {} faces, in its file", (*cooked)->triangles());
                 return text + ">";
             })
        // A geometry never changes.
        .def("__copy__", [](py::object self) { return self; })
        .def("__deepcopy__", [](py::object self, py::handle) { return self; })
        .def(
            py::pickle([](const Geometry& geometry) { return state_of(geometry); },
                       [](const py::tuple& state) { return std::const_pointer_cast<Geometry>(geometry_from(state)); }));

    define(m, "mesh", &mesh, R"(A triangle mesh from arrays, which are copied.

vertices: (V, 3) numbers, metres, finite and at most 1e15. faces: (F, 3) whole numbers, rows of `vertices`, F >= 1.
name: used in messages. Raises TypeError or ValueError for arrays of another type or shape, Error for an index out of
range or a vertex that is not finite. Cost: 10 ns per triangle.)",
           "vertices"_a, "faces"_a, unnamed);
    define(
        m, "load", &any_file,
        R"(A mesh, a map or a terrain from a file of any format, by its extension. A cooked file is read on demand. load_mesh,
load_map and load_terrain have options. Raises Error for a file that is missing or not valid. A UserWarning names each
thing that the reader leaves out, such as the skin of a glTF mesh.)",
        "path"_a);
    define(m, "load_mesh", &mesh_file,
           R"(A mesh from an OBJ, STL, PLY, OFF, glTF, GLB, COLLADA or 3MF file, or from a cooked file.

scale: metres per unit of the file. fit_diagonal: if above 0, scales again so that the diagonal of its AABB has this
length, metres. centre: moves the centre of the AABB to the origin. on_demand: leaves a cooked mesh in its file; a World
reads the parts that other bodies come near. Raises Error for a file that is missing or not valid.)",
           "path"_a, "scale"_a = 1.0, "fit_diagonal"_a = 0.0, "centre"_a = false, "on_demand"_a = false);
    define(
        m, "cook", &cook,
        R"(Writes a mesh, a map or a terrain as a cooked file, NAME.cooked, which load_mesh(path, on_demand=True), load_map and
load_terrain open without reading all of it. Results are the same as for `geometry`. Raises Error if the file cannot be
written.)",
        "geometry"_a, "path"_a);
    define(
        m, "box_mesh",
        [](py::handle half) {
            return share("box", make_box_mesh(vector3(half, {"box_mesh", "half_extents"})));
        },
        "A closed mesh of 12 triangles. half_extents: (3,) metres.", "half_extents"_a);
    define(
        m, "sphere_mesh",
        [](py::handle radius, py::handle triangles) {
            return share("sphere", make_sphere_mesh(number(radius, {"sphere_mesh", "radius"}),
                                                    count(triangles, "sphere_mesh", "triangles")));
        },
        "A closed mesh with corners on a sphere. radius: metres. triangles: their number; one less if it is odd.",
        "radius"_a, "triangles"_a);
    define(
        m, "torus_mesh",
        [](py::handle major, py::handle minor, py::handle triangles) {
            const char* const call = "torus_mesh";
            return share("torus", make_torus_mesh(number(major, {call, "major"}), number(minor, {call, "minor"}),
                                                  count(triangles, call, "triangles")));
        },
        "A closed ring around z. major, minor: radii of the ring and of its tube, metres. triangles: at least 18.",
        "major"_a, "minor"_a, "triangles"_a);
    define(
        m, "torus_knot_mesh",
        [](py::handle p, py::handle q, py::handle major, py::handle minor, py::handle tube, py::handle triangles) {
            const char* const call = "torus_knot_mesh";
            return share("torus knot",
                         make_torus_knot_mesh(count(p, call, "p"), count(q, call, "q"), number(major, {call, "major"}),
                                              number(minor, {call, "minor"}), number(tube, {call, "tube"}),
                                              count(triangles, call, "triangles")));
        },
        "A closed tube along a (p, q) torus knot; p and q coprime. major, minor, tube: radii, metres. triangles: at "
        "least 18.",
        "p"_a, "q"_a, "major"_a, "minor"_a, "tube"_a, "triangles"_a);
}

} // namespace oncollide::python
