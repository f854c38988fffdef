// The models of a World.
#include <oncollide/base/text/printable.hpp>

#include "held_world.hpp"

#include <limits>

namespace oncollide::python {

namespace {

CellState state_of(py::handle value, const char* call)
{
    const Place place{call, "state"};
    const std::string name = text(value, place);
    if (name == "unknown") return CellState::unknown;
    if (name == "free") return CellState::free;
    if (name == "occupied") return CellState::occupied;
    refuse_value(place, "no '" + printable(name) + "'; valid: unknown, free, occupied");
}

ModelHandle add_model(ModelsView& models, py::handle made)
{
    const char* const call = "models.add";
    const GeometryHandle shared = geometry(made, {call, "geometry"});
    const Inside inside(*models.held, call);
    const ModelId id = models.held->world.models().add(shared);
    models.held->geometries[id] = shared;
    return {id};
}

void replace_model(ModelsView& models, py::handle model, py::handle made)
{
    const char* const call = "models.replace";
    const ModelId id = model_of(model, {call, "model"});
    const GeometryHandle shared = geometry(made, {call, "geometry"});
    const Inside inside(*models.held, call);
    models.held->world.models().replace(id, shared);
    models.held->geometries[id] = shared;
}

void remove_model(ModelsView& models, py::handle model)
{
    const char* const call = "models.remove";
    const ModelId id = model_of(model, {call, "model"});
    const Inside inside(*models.held, call);
    models.held->world.models().remove(id);
    models.held->geometries.erase(id);
}

/// As Python gave it; a copy where the World has changed it, or a Robot made it.
std::shared_ptr<Geometry> geometry_of(ModelsView& models, py::handle model)
{
    const char* const call = "models.geometry";
    const ModelId id = model_of(model, {call, "model"});
    const Looking looking(*models.held, call);
    const Geometry& now = models.held->world.models().geometry(id);
    const auto given = models.held->geometries.find(id);
    if (given != models.held->geometries.end() && given->second.get() == &now)
        return std::const_pointer_cast<Geometry>(given->second);
    return std::make_shared<Geometry>(now);
}

py::array model_bounds(ModelsView& models, py::handle model, py::handle at)
{
    const char* const call = "models.bounds";
    const ModelId id = model_of(model, {call, "model"});
    const Poses poses(at, {call, "pose"});
    std::vector<double> made;
    {
        const Looking looking(*models.held, call);
        for (std::size_t i = 0; i < poses.size(); ++i) {
            const Aabb box = models.held->world.models().bounds(id, poses[i]);
            made.insert(made.end(), box.min.begin(), box.min.end());
            made.insert(made.end(), box.max.begin(), box.max.end());
        }
    }
    const auto count = static_cast<py::ssize_t>(poses.size());
    if (poses.one()) return py::array_t<double>({2, 3}, made.data());
    return py::array_t<double>({count, py::ssize_t{2}, py::ssize_t{3}}, made.data());
}

/// None: no limit.
std::size_t most_of(py::handle limit, const char* call)
{
    constexpr std::size_t no_limit = std::numeric_limits<std::size_t>::max();
    return limit.is_none() ? no_limit : whole(limit, {call, "most"}, no_limit - 1);
}

py::array pairs_array(const std::vector<PairOf<std::uint32_t>>& pairs)
{
    static_assert(sizeof(PairOf<std::uint32_t>) == 2 * sizeof(std::uint32_t));
    const auto count = static_cast<py::ssize_t>(pairs.size());
    return py::array_t<std::uint32_t>({count, py::ssize_t{2}}, reinterpret_cast<const std::uint32_t*>(pairs.data()));
}

void set_vertices(ModelsView& models, py::handle model, py::handle positions, py::handle first)
{
    const char* const call = "models.set_vertices";
    const Place place{call, "positions"};
    const ModelId id = model_of(model, {call, "model"});
    const py::array array = doubles(positions, place);
    if (!has_shape(array, {-1, 3})) refuse_value(place, "expected shape (N, 3), got " + shape_of(array));
    static_assert(sizeof(Eigen::Vector3d) == 3 * sizeof(double));
    const std::span vertices(static_cast<const Eigen::Vector3d*>(array.data()),
                             static_cast<std::size_t>(array.shape(0)));
    const bool all = first.is_none();
    const std::size_t from = all ? 0 : whole(first, {call, "first"}, std::numeric_limits<std::uint32_t>::max());
    const Inside inside(*models.held, call);
    const Released released;
    if (all)
        models.held->world.models().set_vertices(id, vertices);
    else
        models.held->world.models().set_vertices(id, from, vertices);
}

void set_heights(ModelsView& models, py::handle terrain, py::handle heights, py::handle column, py::handle row)
{
    const char* const call = "models.set_heights";
    const Place place{call, "heights"};
    const ModelId id = model_of(terrain, {call, "terrain"});
    const py::array array = doubles(heights, place);
    if (!has_shape(array, {-1, -1})) refuse_value(place, "expected shape (rows, columns), got " + shape_of(array));
    constexpr std::uint32_t most = std::numeric_limits<std::uint32_t>::max();
    const auto limited = [&](py::ssize_t length) {
        if (length > most) refuse_value(place, "too many rows or columns");
        return static_cast<std::uint32_t>(length);
    };
    const TerrainRectangle where{static_cast<std::uint32_t>(whole(column, {call, "column"}, most)),
                                 static_cast<std::uint32_t>(whole(row, {call, "row"}, most)), limited(array.shape(1)),
                                 limited(array.shape(0))};
    const std::span values(static_cast<const double*>(array.data()), static_cast<std::size_t>(array.size()));
    const Inside inside(*models.held, call);
    const Released released;
    models.held->world.models().set_heights(id, where, values);
}

/// Lets `change` change the map of a model; other Python threads run meanwhile.
template <class Change>
void edit(ModelsView& models, const char* call, py::handle map, Change change)
{
    const ModelId id = model_of(map, {call, "map"});
    const Inside inside(*models.held, call);
    const Released released;
    models.held->world.models().edit(id, change);
}

void bind_maps(py::class_<ModelsView>& models)
{
    using namespace py::literals;
    define(
        models, "set_cells",
        [](ModelsView& view, py::handle map, py::handle at, py::handle state) {
            const char* const call = "models.set_cells";
            const std::vector<Eigen::Vector3d> places = points(at, {call, "points"});
            const CellState to = state_of(state, call);
            edit(view, call, map, [&](OccupancyMap& cells) { cells.set(places, to); });
        },
        R"(Sets the cells of a map that contain these points to a state: 'unknown', 'free' or 'occupied'.

points: (N, 3) metres, in the map's frame. The Geometry does not change; this World uses a copy from now on.)",
        "map"_a, "points"_a, "state"_a);
    define(
        models, "set_cells_in_box",
        [](ModelsView& view, py::handle map, py::handle low, py::handle high, py::handle state) {
            const char* const call = "models.set_cells_in_box";
            const Aabb box = box_of(low, high, call);
            const CellState to = state_of(state, call);
            edit(view, call, map, [&](OccupancyMap& cells) { cells.set(box, to); });
        },
        "The same for the cells whose centres are in a box of the map's frame. low, high: (3,) metres.", "map"_a,
        "low"_a, "high"_a, "state"_a);
    define(
        models, "replace_cells",
        [](ModelsView& view, py::handle map, py::handle low, py::handle high, py::handle by) {
            const char* const call = "models.replace_cells";
            const Aabb box = box_of(low, high, call);
            const GeometryHandle other = geometry(by, {call, "by"});
            const auto* const from = std::get_if<OccupancyMap>(&other->data);
            if (!from)
                refuse_value({call, "by"}, "expected a map, as oncollide.occupancy_map() and load_map() make it");
            edit(view, call, map, [&](OccupancyMap& cells) { cells.replace(box, *from); });
        },
        "Copies the states of the same cells from another map, a Geometry of the same resolution.", "map"_a, "low"_a,
        "high"_a, "by"_a);
    define(
        models, "insert_scan",
        [](ModelsView& view, py::handle map, py::handle at, py::handle origin, py::handle max_range) {
            const char* const call = "models.insert_scan";
            const std::vector<Eigen::Vector3d> places = points(at, {call, "points"});
            const Eigen::Vector3d from = vector3(origin, {call, "origin"});
            const double range = max_range.is_none() ? -1 : number(max_range, {call, "max_range"});
            edit(view, call, map, [&](OccupancyMap& cells) { cells.insert_scan(places, from, range); });
        },
        R"(Inserts a sensor's scan into a map, with OctoMap's rules for hits and misses.

points: (N, 3) metres, in the map's frame. origin: (3,), the sensor's position. max_range: longer rays are cut there and
hit nothing; None: no limit.)",
        "map"_a, "points"_a, "origin"_a, "max_range"_a = py::none());
}

} // namespace

ModelId model_of(py::handle value, const Place& place)
{
    if (!py::isinstance<ModelHandle>(value)) refuse_type(place, "a Model, as models.add() returns it", value);
    return py::cast<const ModelHandle&>(value).id;
}

void bind_models(py::module_& m)
{
    using namespace py::literals;
    define(
        m, "self_contacts",
        [](py::handle mesh, py::handle limit) {
            const char* const call = "self_contacts";
            const GeometryHandle shared = geometry(mesh, {call, "mesh"});
            const std::size_t most = most_of(limit, call);
            std::vector<PairOf<std::uint32_t>> pairs;
            {
                const Released released;
                World world({.threads = 0});
                pairs = world.models().self_contacts(world.models().add(shared), most);
            }
            return pairs_array(pairs);
        },
        "The pairs of triangles of a mesh that meet each other, as models.self_contacts().", "mesh"_a,
        "most"_a = py::none());
    py::class_<ModelHandle> model(m, "Model", R"(A geometry in one World, with all data derived from it.

World.models.add() returns it. int(model) is its number, for arrays of models (uint64).)");
    model
        .def("__eq__",
             [](const ModelHandle& a, py::handle b) {
                 return py::isinstance<ModelHandle>(b) && a.id == py::cast<const ModelHandle&>(b).id;
             })
        .def("__hash__", [](const ModelHandle& a) { return std::hash<ModelId>()(a.id); })
        .def("__repr__", [](const ModelHandle& a) {
            return fmt::format("<oncollide.Model {} of World {}>", a.id.slot, a.id.world);
        });
    define(
        model, "__int__", [](const ModelHandle& a) { return number_of(a.id); }, "Its number, for arrays of models.");
    refuse_pickles(model, "Model", "it is of one World; send its Geometry, and add it to a World there");

    py::class_<ModelsView> models(m, "Models", "The models of a World, as World.models: geometries that bodies share.");
    models.def(py::init<HeldWorld&>());
    refuse_pickles(models, "Models", "they are of one World");
    define(
        models, "add", &add_model,
        "Shares a Geometry with the World and returns its Model. Builds no trees: they grow where bodies come close.",
        "geometry"_a);
    define(models, "replace", &replace_model, "Replaces the Geometry of a model, and so of all its bodies.", "model"_a,
           "geometry"_a);
    define(models, "remove", &remove_model, "Removes a model. Raises Error while a body uses it.", "model"_a);
    define(models, "geometry", &geometry_of,
           "The Geometry of a model; a copy if set_cells(), set_vertices() or others have changed it.", "model"_a);
    define(models, "set_heights", &set_heights,
           R"(Gives heights of a terrain new values, for all bodies of the model.

heights: (rows, columns) metres, read where they are if they are contiguous float64; nan and the terrain's no_data are
holes, if it was made with no_data. column, row: the place of heights[0, 0] in the terrain. The tree follows, at the
cost of the change. The Geometry does not change; this World uses a copy of 8 bytes per height from now on.)",
           "terrain"_a, "heights"_a, "column"_a = 0, "row"_a = 0);
    define(models, "set_vertices", &set_vertices,
           R"(Gives the vertices of a mesh new positions, for all bodies of the model; the triangles stay.

positions: (N, 3) metres, in the mesh's frame, read where they are if they are contiguous float64. first: the number of
the first vertex that they replace; None: they are all vertices. Trees stay, and are fitted anew where tests reach them.
The Geometry does not change; this World uses a copy from now on.)",
           "model"_a, "positions"_a, "first"_a = py::none());
    define(
        models, "closed",
        [](ModelsView& view, py::handle of) {
            const ModelId id = model_of(of, {"models.closed", "model"});
            return computed(*view.held, "models.closed", false, [&](const World& w) { return w.models().closed(id); });
        },
        "True for a mesh with an inside, as Geometry.closed.", "model"_a);
    define(
        models, "self_contacts",
        [](ModelsView& view, py::handle of, py::handle limit) {
            const char* const call = "models.self_contacts";
            const ModelId id = model_of(of, {call, "model"});
            const std::size_t most = most_of(limit, call);
            return pairs_array(
                computed(*view.held, call, true, [&](const World& w) { return w.models().self_contacts(id, most); }));
        },
        R"(The pairs of triangles of a mesh that meet beyond the vertices and edges that they share, exactly.

Returns uint32 (N, 2), each pair once and the smaller number first, sorted; no pair for other kinds of geometry.
Vertices at equal positions count as one. most: the search ends with this many pairs.)",
        "model"_a, "most"_a = py::none());
    define(
        models, "near_features",
        [](ModelsView& view, py::handle of, py::handle dhat, py::handle rings, py::handle rest, py::handle distance) {
            const char* const call = "models.near_features";
            const ModelId id = model_of(of, {call, "model"});
            const double within = number(dhat, {call, "dhat"});
            SelfNearOptions options;
            options.rings = static_cast<std::uint32_t>(whole(rings, {call, "rings"}, 0xffffffff));
            options.rest_distance = number(distance, {call, "rest_distance"});
            std::vector<Eigen::Vector3d> positions;
            if (!rest.is_none()) positions = points(rest, {call, "rest"});
            options.rest = positions;
            return array_of(computed(*view.held, call, true,
                                     [&](const World& w) { return w.models().near_features(id, within, options); }));
        },
        R"(All pairs of features of one mesh at most `dhat` metres apart that are not neighbours, for a barrier.

Structured (N,), as pairs.near_features(), with a < b, sorted, in the frame of the mesh. rings: features that fewer edges of
the mesh connect are neighbours; with 1, neighbours share a vertex. rest: float64 (vertices, 3), positions in a rest shape;
features that are at most rest_distance metres apart there are neighbours, too.)",
        "model"_a, "dhat"_a, "rings"_a = 1, "rest"_a = py::none(), "rest_distance"_a = 0.0);
    define(models, "bounds", &model_bounds,
           R"(The AABB of a model at a pose, metres, as step() computes it for a body.

Returns its least and its greatest corner, float64 (2, 3); for many poses (N, 2, 3).)",
           "model"_a, "pose"_a = py::none());
    define(
        models, "at",
        [](ModelsView& view, py::handle slot) -> py::object {
            const std::uint32_t number = bits(slot, {"models.at", "slot"});
            const Looking looking(*view.held, "models.at");
            const ModelId id = view.held->world.models().at(number);
            return id ? py::cast(ModelHandle{id}) : py::none();
        },
        "The Model in a slot, or None if the slot is free. Models take the slots 0, 1, 2 and so on.", "slot"_a);
    define(
        models, "__contains__",
        [](ModelsView& view, py::handle of) {
            const ModelId id = model_of(of, {"models.__contains__", "model"});
            const Looking looking(*view.held, "models.__contains__");
            return view.held->world.models().contains(id);
        },
        "True if this Model is one of this World, and was not removed.", "model"_a);
    define(
        models, "__len__",
        [](ModelsView& view) {
            const Looking looking(*view.held, "models.__len__");
            return view.held->world.models().size();
        },
        "Number of models.");
    bind_maps(models);
}

} // namespace oncollide::python
