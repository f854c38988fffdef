// World and its models.
#include "held_world.hpp"

#include <atomic>

#include <fmt/format.h>

namespace oncollide::python {

namespace {

std::uint64_t next_world()
{
    static std::atomic<std::uint64_t> worlds = 0;
    return ++worlds;
}

} // namespace

HeldWorld::HeldWorld(const Settings& settings)
    : world(with_stop(settings)), number(next_world()), tied(settings.backend != BackendKind::cpu)
{
}

Settings HeldWorld::with_stop(Settings settings)
{
    settings.stop = [this] { return interrupts.requested(); };
    return settings;
}

void HeldWorld::at_home(const char* call) const
{
    if (tied && std::this_thread::get_id() != home)
        throw Error(ErrorKind::usage, fmt::format("{}: a World with a GPU backend belongs to the thread that made it; "
                                                  "call it from there, or make it with backend='cpu'",
                                                  call));
}

ModelId model_of(const HeldWorld& held, py::handle value, const Place& place)
{
    if (!py::isinstance<ModelHandle>(value)) refuse_type(place, "a Model, as World.models().add() returns it", value);
    const auto& model = py::cast<const ModelHandle&>(value);
    if (model.world != held.number)
        refuse_value(place, "this model is of another World; add its geometry to this one, which copies nothing");
    return model.id;
}

std::uint32_t bits(py::handle value, const Place& place)
{
    return static_cast<std::uint32_t>(whole(value, place, 0xffffffffu));
}

Aabb box_of(py::handle low, py::handle high, const char* call)
{
    return {vector3(low, {call, "low"}), vector3(high, {call, "high"})};
}

void bind_world(py::module_& m)
{
    using namespace py::literals;
    py::class_<ModelHandle> model_class(
        m, "Model", R"(A geometry in one World, with all data derived from it; returned by World.models().add().)");
    model_class
        .def("__eq__",
             [](const ModelHandle& a, py::handle b) {
                 return py::isinstance<ModelHandle>(b) && a == py::cast<const ModelHandle&>(b);
             })
        .def(
            "__hash__",
            [](const ModelHandle& model) { return model.world * 0x9e3779b97f4a7c15u ^ std::hash<ModelId>()(model.id); })
        .def("__repr__", [](const ModelHandle& model) {
            return fmt::format("<oncollide.Model {} of World {}>", model.id.slot, model.world);
        });
    refuse_pickles(model_class, "Model", "it is of one World; send its Geometry, and add() it to a World there");

    const std::string text = R"(World(**settings)
--

Holds bodies and their models, which may be added, removed and moved between steps, and finds the bodies that collide.

    world = oncollide.World(max_error=0.01)
    crane = world.models().add(oncollide.load_mesh("crane.obj"))
    body = world.bodies().add(crane, pose=np.eye(4))
    for pair in world.step().pairs: ...

Settings, all by keyword:
)" + settings_text() + R"(
Bodies have ids, whole numbers. The id of a removed body is stale: using it raises Error. Poses are float64: (4, 4),
body to world, metres, or (7,) with position and quaternion x y z qx qy qz qw.

Raises TypeError and ValueError for arguments of another type, shape or range, and Error for other invalid arguments;
the World is then unchanged. One thread at a time may change or step a World; queries, contacts and distances may run
in parallel. Other Python threads can run during calls that compute.)";
    WorldClass world(m, "World", text.c_str());

    world.def(py::init(
        [](const py::kwargs& settings) { return std::make_unique<HeldWorld>(settings_of(settings, "World")); }));

    world.def(
        "add",
        [](HeldWorld& held, py::handle made) {
            GeometryHandle shared = geometry(made, {"World.add", "geometry"});
            const Inside inside(held, "World.add");
            return ModelHandle{held.number, held.world.models().add(std::move(shared))};
        },
        "geometry"_a, R"(add(self, geometry)
--

Shares a Geometry with this World and returns its Model. Builds no trees yet: they grow where bodies come close.)");
    world.def(
        "replace",
        [](HeldWorld& held, py::handle model, py::handle made) {
            const ModelId id = model_of(held, model, {"World.replace", "model"});
            GeometryHandle shared = geometry(made, {"World.replace", "geometry"});
            const Inside inside(held, "World.replace");
            held.world.models().replace(id, std::move(shared));
        },
        "model"_a, "geometry"_a, R"(replace(self, model, geometry)
--

Replaces the Geometry of a model and so of all its bodies.)");
    world.def(
        "remove",
        [](HeldWorld& held, py::handle model) {
            const ModelId id = model_of(held, model, {"World.remove", "model"});
            const Inside inside(held, "World.remove");
            held.world.models().remove(id);
        },
        "model"_a, R"(remove(self, model)
--

Removes a model. Raises Error while a body uses it.)");

    refuse_pickles(world, "World", "make one in each process, and add() the geometries there, which can be pickled");
    bind_bodies(world);
    bind_frames(m, world);
    bind_world_queries(world);
    bind_world_pairs(world);
    bind_world_sweeps(world);
    bind_maps(world);
    world.def(
        "inspect",
        [](HeldWorld& held) {
            WorldInfo info;
            {
                const Looking looking(held, "World.inspect");
                const Released released;
                info = held.world.inspect();
            }
            return py::dict("bodies"_a = info.bodies, "models"_a = info.models, "frames"_a = info.frames,
                            "bytes"_a = info.bytes, "backend"_a = info.backend, "renderer"_a = info.renderer,
                            "backend_note"_a = info.backend_note);
        },
        R"(inspect(self)
--

The state of the World as a dict: bodies, models, frames, bytes (without the geometries), backend, renderer,
backend_note. See also totals and file_faults.)");
    world.def_property_readonly("bytes", look("World.bytes", [](const World& w) { return w.inspect().bytes; }),
                                "Memory of bodies, AABBs and trees, bytes, without the geometries (int).");
    world.def_property_readonly("backend", look("World.backend", [](const World& w) { return w.inspect().backend; }),
                                "The backend that finds grey cells, e.g. 'cpu (avx2)' (str).");
    world.def_property_readonly(
        "file_faults",
        look("World.file_faults",
             [](const World& w) {
                 py::list made;
                 for (const std::string& fault : w.inspect().file_faults) // a path may contain bytes that are not UTF-8
                     made.append(py::reinterpret_steal<py::object>(
                         PyUnicode_DecodeFSDefaultAndSize(fault.data(), static_cast<py::ssize_t>(fault.size()))));
                 return made;
             }),
        "Faults of cooked files so far; the pairs that need these parts stay undecided (list of str).");
    world.def("__repr__", [](const HeldWorld& held) { // also while another thread uses the World
        return fmt::format("<oncollide.World {}>", held.number);
    });
}

} // namespace oncollide::python
