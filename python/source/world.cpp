// World, without its parts.
#include "held_world.hpp"

namespace oncollide::python {

namespace {

SweepStop stop_of(py::handle value, const Place& place)
{
    const std::string name = text(value, place);
    for (const SweepStop stop : {SweepStop::contact, SweepStop::touch, SweepStop::press})
        if (name == name_of(stop)) return stop;
    refuse_value(place, "expected \"contact\", \"touch\" or \"press\", got \"" + name + "\"");
}

/// Text that may contain bytes that are not UTF-8, such as a path.
py::object path_text(const std::string& text)
{
    return py::reinterpret_steal<py::object>(
        PyUnicode_DecodeFSDefaultAndSize(text.data(), static_cast<py::ssize_t>(text.size())));
}

py::dict inspect(HeldWorld& held)
{
    using namespace py::literals;
    const WorldInfo info = computed(held, "World.inspect", false, [](const World& w) { return w.inspect(); });
    py::list faults;
    for (const std::string& fault : info.file_faults) faults.append(path_text(fault));
    return py::dict("bodies"_a = info.bodies, "models"_a = info.models, "frames"_a = info.frames,
                    "bytes"_a = info.bytes, "backend"_a = info.backend, "renderer"_a = info.renderer,
                    "backend_note"_a = info.backend_note, "totals"_a = stage_list(info.totals),
                    "file_faults"_a = faults);
}

} // namespace

HeldWorld::HeldWorld(const Settings& settings) : world(with_stop(settings)), tied(settings.backend != BackendKind::cpu)
{
}

Settings HeldWorld::with_stop(Settings settings)
{
    settings.stop = [this] { return interrupts.requested(); };
    return settings;
}

Users& HeldWorld::users_for(const char* call)
{
    if (tied && std::this_thread::get_id() != home)
        throw Error(ErrorKind::usage, fmt::format("{}: a World with a GPU backend belongs to the thread that made it; "
                                                  "call it from there, or make it with backend='cpu'",
                                                  call));
    if (interrupts.in_handler())
        throw Error(ErrorKind::usage,
                    fmt::format("{}: a signal handler cannot use the World that it interrupts", call));
    return users;
}

std::uint32_t bits(py::handle value, const Place& place)
{
    return static_cast<std::uint32_t>(whole(value, place, 0xffffffffu));
}

CollisionFilter filter_of(py::handle layer, py::handle mask, py::handle group, const char* call)
{
    return {bits(layer, {call, "layer"}), bits(mask, {call, "mask"}), bits(group, {call, "group"})};
}

MotionPath motion_path(py::handle value, const Place& place)
{
    const std::string name = text(value, place);
    if (name == "linear") return MotionPath::linear;
    if (name == "screw") return MotionPath::screw;
    refuse_value(place, "expected \"linear\" or \"screw\", got \"" + name + "\"");
}

SweepOptions sweep_options(py::handle time, py::handle gap, py::handle steps, py::handle stop, const char* call)
{
    return {number(time, {call, "time_tolerance"}), number(gap, {call, "gap_tolerance"}),
            static_cast<int>(whole(steps, {call, "most_steps"}, 1'000'000'000)), stop_of(stop, {call, "stop"})};
}

DistanceOptions distance_options(py::handle tolerance, py::handle cutoff, const char* call)
{
    return {.tolerance = number(tolerance, {call, "tolerance"}), .cutoff = limit_of(cutoff, {call, "cutoff"})};
}

ManifoldOptions manifold_options(py::handle margin, py::handle normal_spread, py::handle points_per_region,
                                 py::handle regions_per_pair, py::handle points_per_pair, py::handle points_in_all,
                                 py::handle measures, const char* call)
{
    return {.margin = number(margin, {call, "margin"}),
            .normal_spread = number(normal_spread, {call, "normal_spread"}),
            .points_per_region = bits(points_per_region, {call, "points_per_region"}),
            .regions_per_pair = bits(regions_per_pair, {call, "regions_per_pair"}),
            .points_per_pair = bits(points_per_pair, {call, "points_per_pair"}),
            .points_in_all = bits(points_in_all, {call, "points_in_all"}),
            .measures = truth(measures, {call, "measures"})};
}

Aabb box_of(py::handle low, py::handle high, const char* call)
{
    return {vector3(low, {call, "low"}), vector3(high, {call, "high"})};
}

void bind_world(py::module_& m)
{
    using namespace py::literals;
    const std::string text = R"(World(**settings)
--

Holds bodies and their models, which may be added, removed and moved between steps, and finds the bodies that collide.

    world = oncollide.World(max_error=0.01)
    crane = world.models.add(oncollide.load_mesh("crane.obj"))
    body = world.bodies.add(crane, pose=np.eye(4))
    for pair in world.step().pairs: ...

Settings, all by keyword:
)" + settings_text() + R"(
One or many, one name: a call with one body, pose or segment gives its result; with an array of them it gives an array
of results. Where a result is a list, many of them are (items, offsets): list i is items[offsets[i]:offsets[i + 1]];
offsets is int64 (N + 1,). Calls with many run on the World's threads, and Ctrl-C ends them soon.

Bodies have ids, whole numbers; many ids are an integer array (N,). The id of a removed body is stale: using it raises
Error. Poses are float64: (4, 4), body to world, metres, or (7,) with position and quaternion x y z qx qy qz qw; many
are (N, 4, 4) or (N, 7); None is the identity.

Raises TypeError and ValueError for arguments of another type, shape or range, and Error for other invalid arguments;
the World is then unchanged. One thread at a time may change or step a World; queries of pairs and space may run in
parallel. Other Python threads can run during calls that compute.)";
    WorldClass world(m, "World", text.c_str());
    refuse_pickles(world, "World", "make one in each process, and add the geometries there, which can be pickled");
    world.def(py::init(
        [](const py::kwargs& settings) { return std::make_shared<HeldWorld>(settings_of(settings, "World")); }));
    bind_models(m);
    bind_bodies(m);
    bind_pairs(m);
    bind_space(m);
    bind_frames(m, world);
    bind_manifolds(m, world);

    const SharedArguments with;
    define(
        world, "set_sweep_options",
        [](HeldWorld& held, py::handle time, py::handle gap, py::handle steps, py::handle stop) {
            const char* const call = "World.set_sweep_options";
            const SweepOptions options = sweep_options(time, gap, steps, stop, call);
            const Inside inside(held, call);
            held.world.set_sweep_options(options);
        },
        "How step() looks for contacts of moving bodies: as in pairs.sweep().", with.time_tolerance, with.gap_tolerance,
        with.most_steps, with.stop);
    world.def_property_readonly("sweep_options",
                                look("World.sweep_options",
                                     [](const World& w) {
                                         const SweepOptions& o = w.sweep_options();
                                         return py::dict("time_tolerance"_a = o.time_tolerance,
                                                         "gap_tolerance"_a = o.gap_tolerance,
                                                         "most_steps"_a = o.most_steps, "stop"_a = name_of(o.stop));
                                     }),
                                "The arguments of set_sweep_options() (dict).");
    world.def_property_readonly("settings",
                                look("World.settings", [](const World& w) { return dict_of(w.settings()); }),
                                "The settings (dict): World(**settings) makes a World like this one. 'exact' has the "
                                "level that 'auto' stands for.");
    world.def_property_readonly("hash", look("World.hash", [](const World& w) { return w.hash(); }),
                                "Hash of all frames so far; equal input gives an equal hash (int).");
    define(world, "inspect", &inspect,
           R"(The state of the World (dict).

bodies, models, frames: their numbers. bytes: memory of bodies, AABBs and trees, without the geometries. backend: it finds
grey cells, e.g. 'cpu (avx2)'; renderer: of a GPU; backend_note: why the backend is not the expected one. totals: sums
over all frames, as Frame.stages. file_faults: a line (str) for each part of a cooked file that could not be read; the
pairs that need it stay undecided.)");
}

} // namespace oncollide::python
