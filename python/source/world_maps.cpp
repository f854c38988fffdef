// Changes of a World's occupancy maps.
#include "held_world.hpp"

#include <oncollide/base/text/printable.hpp>

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

} // namespace

void bind_maps(WorldClass& world)
{
    using namespace py::literals;
    world.def(
        "set_cells",
        [](HeldWorld& held, py::handle map, py::handle at, py::handle state) {
            const char* const call = "World.set_cells";
            const ModelId id = model_of(held, map, {call, "map"});
            const std::vector<Eigen::Vector3d> places = points(at, {call, "points"});
            const CellState to = state_of(state, call);
            const Inside inside(held, call);
            held.world.set_cells(id, places, to);
        },
        "map"_a, "points"_a, "state"_a, R"(set_cells(self, map, points, state)
--

Sets the cells of a map's Model that contain these points to a state: 'unknown', 'free' or 'occupied'.

points: (N, 3) metres, in the map's frame. The Geometry does not change; this World uses a copy from now on.)");
    world.def(
        "set_cells_in_box",
        [](HeldWorld& held, py::handle map, py::handle low, py::handle high, py::handle state) {
            const char* const call = "World.set_cells_in_box";
            const ModelId id = model_of(held, map, {call, "map"});
            const Aabb box = box_of(low, high, call);
            const CellState to = state_of(state, call);
            const Inside inside(held, call);
            held.world.set_cells(id, box, to);
        },
        "map"_a, "low"_a, "high"_a, "state"_a, R"(set_cells_in_box(self, map, low, high, state)
--

The same for the cells whose centres are in a box of the map's frame. low, high: (3,) metres.)");
    world.def(
        "replace_cells",
        [](HeldWorld& held, py::handle map, py::handle low, py::handle high, py::handle by) {
            const char* const call = "World.replace_cells";
            const ModelId id = model_of(held, map, {call, "map"});
            const Aabb box = box_of(low, high, call);
            const GeometryHandle other = geometry(by, {call, "by"});
            const auto* const cells = std::get_if<OccupancyMap>(&other->data);
            if (!cells)
                refuse_value({call, "by"}, "expected a map, as oncollide.occupancy_map() and load_map() make it");
            const Inside inside(held, call);
            held.world.replace_cells(id, box, *cells);
        },
        "map"_a, "low"_a, "high"_a, "by"_a, R"(replace_cells(self, map, low, high, by)
--

Copies the states of the same cells from another map, a Geometry of the same resolution.)");
    world.def(
        "insert_scan",
        [](HeldWorld& held, py::handle map, py::handle at, py::handle origin, py::handle max_range) {
            const char* const call = "World.insert_scan";
            const ModelId id = model_of(held, map, {call, "map"});
            const std::vector<Eigen::Vector3d> places = points(at, {call, "points"});
            const Eigen::Vector3d from = vector3(origin, {call, "origin"});
            const double range = max_range.is_none() ? -1 : number(max_range, {call, "max_range"});
            const Inside inside(held, call);
            const Released released;
            held.world.insert_scan(id, places, from, range);
        },
        "map"_a, "points"_a, "origin"_a, "max_range"_a = py::none(),
        R"(insert_scan(self, map, points, origin, max_range=None)
--

Inserts a sensor's scan into a map's Model, with OctoMap's rules for hits and misses.

points: (N, 3) metres, in the map's frame. origin: (3,), the sensor's position. max_range: longer rays are cut there and
hit nothing; None: no limit.)");
}

} // namespace oncollide::python
