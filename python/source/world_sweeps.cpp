// Queries of a World about moving models.
#include "held_world.hpp"

namespace oncollide::python {

MotionPath motion_path(py::handle value, const Place& place)
{
    const std::string name = text(value, place);
    if (name == "linear") return MotionPath::linear;
    if (name == "screw") return MotionPath::screw;
    refuse_value(place, "expected \"linear\" or \"screw\", got \"" + name + "\"");
}

namespace {

/// The motions of one side, from each pose of one column to the pose of another. A column of one pose serves all.
std::vector<RigidMotion> motions(py::handle from, py::handle to, MotionPath path, const char* call,
                                 const char* name_from, const char* name_to)
{
    const Poses first(from, {call, name_from}), last(to, {call, name_to});
    const std::size_t count = std::max(first.size(), last.size());
    for (const auto& [poses, name] : {std::pair(&first, name_from), std::pair(&last, name_to)})
        if (poses->size() != count && !poses->one())
            refuse_value({call, name},
                         "expected " + std::to_string(count) + " poses, or one, got " + std::to_string(poses->size()));
    std::vector<RigidMotion> made;
    for (std::size_t i = 0; i < count; ++i)
        made.emplace_back(first[first.one() ? 0 : i], last[last.one() ? 0 : i], path);
    return made;
}

SweepStop stop_of(py::handle value, const Place& place)
{
    const std::string name = text(value, place);
    for (const SweepStop stop : {SweepStop::contact, SweepStop::touch, SweepStop::press})
        if (name == name_of(stop)) return stop;
    refuse_value(place, "expected \"contact\", \"touch\" or \"press\", got \"" + name + "\"");
}

SweepOptions options_of(py::handle time, py::handle gap, py::handle steps, py::handle stop, const char* call)
{
    return {number(time, {call, "time_tolerance"}), number(gap, {call, "gap_tolerance"}),
            static_cast<int>(whole(steps, {call, "most_steps"}, 1'000'000'000)), stop_of(stop, {call, "stop"})};
}

void set_sweep_options(HeldWorld& held, py::handle time, py::handle gap, py::handle steps, py::handle stop)
{
    const char* const call = "World.set_sweep_options";
    const SweepOptions options = options_of(time, gap, steps, stop, call);
    const Inside inside(held, call);
    held.world.set_sweep_options(options);
}

py::array sweep(HeldWorld& held, py::handle a, py::handle a_from, py::handle a_to, py::handle b, py::handle b_from,
                py::handle b_to, py::handle path, py::handle time, py::handle gap, py::handle steps, py::handle stop)
{
    const char* const call = "World.sweep";
    const ModelId first = model_of(held, a, {call, "a"}), second = model_of(held, b, {call, "b"});
    const MotionPath along = motion_path(path, {call, "path"});
    const std::vector<RigidMotion> of_a = motions(a_from, a_to, along, call, "a_from", "a_to"),
                                   of_b = motions(b_from, b_to, along, call, "b_from", "b_to");
    const SweepOptions options = options_of(time, gap, steps, stop, call);
    const std::size_t count = std::max(of_a.size(), of_b.size());
    if ((of_a.size() != count && of_a.size() != 1) || (of_b.size() != count && of_b.size() != 1))
        refuse_value({call, "b_from"}, "expected as many motions as of a, " + std::to_string(of_a.size()) +
                                           ", or one, got " + std::to_string(of_b.size()));
    std::vector<SweepResult> found(count);
    {
        const Looking looking(held, call);
        const Released released;
        std::vector<PairOf<MovingModel>> pairs;
        for (std::size_t i = 0; i < count; ++i)
            pairs.push_back({{first, of_a[of_a.size() == 1 ? 0 : i]}, {second, of_b[of_b.size() == 1 ? 0 : i]}});
        held.world.pairs().sweep(pairs, found, options);
    }
    return array_of(result_types().sweep, std::move(found));
}

py::array cast_model(HeldWorld& held, py::handle model, py::handle from, py::handle to, py::handle layer,
                     py::handle mask, py::handle group, py::handle path, py::handle time, py::handle gap,
                     py::handle steps, py::handle stop)
{
    const char* const call = "World.cast_model";
    const ModelId mine = model_of(held, model, {call, "model"});
    const CollisionFilter filter = filter_of(layer, mask, group, call);
    const std::vector<RigidMotion> ways = motions(from, to, motion_path(path, {call, "path"}), call, "starts", "ends");
    const SweepOptions options = options_of(time, gap, steps, stop, call);
    std::vector<SweepHit> hits(ways.size());
    {
        const Looking looking(held, call);
        const Released released;
        std::vector<MovingModel> models;
        for (const RigidMotion& way : ways) models.push_back({mine, way});
        held.world.space().cast(models, filter, hits, options);
    }
    return array_of(result_types().sweep_hit, std::move(hits));
}

} // namespace

void bind_world_sweeps(WorldClass& world)
{
    using namespace py::literals;
    const py::int_ all(0xffffffffu);
    const SweepOptions usual;
    world.def("set_sweep_options", &set_sweep_options, "time_tolerance"_a = usual.time_tolerance,
              "gap_tolerance"_a = usual.gap_tolerance, "most_steps"_a = usual.most_steps,
              "stop"_a = std::string(name_of(usual.stop)),
              R"(set_sweep_options(self, time_tolerance=0.0001, gap_tolerance=0.0001, most_steps=10000, stop="contact")
--

How step() looks for contacts of moving bodies: as in sweep().)");
    world.def(
        "sweep", &sweep, "a"_a, "a_from"_a, "a_to"_a, "b"_a, "b_from"_a, "b_to"_a, "path"_a = "linear",
        "time_tolerance"_a = usual.time_tolerance, "gap_tolerance"_a = usual.gap_tolerance,
        "most_steps"_a = usual.most_steps, "stop"_a = std::string(name_of(usual.stop)),
        R"(sweep(self, a, a_from, a_to, b, b_from, b_to, path="linear", time_tolerance=0.0001, gap_tolerance=0.0001, most_steps=10000, stop="contact")
--

When two moving models first meet, over the time from 0 to 1; many motions on the World's threads.

a, b: models. a_from and the others: poses (N, 4, 4) or (N, 7), metres, or one pose for all. path: "linear" (the origin
in a straight line, the rotation along the shorter arc) or "screw". stop: "contact" (the first certain contact; a gap
that rounding hides is passed), "touch" (such a gap, too) or "press" (the first contact that gets deeper
than gap_tolerance; bodies may touch, slide along each other, and part).

Returns a structured array (N,): verdict (uint8: SEPARATE, COLLIDING, WITHIN where only a clearance or rounding is
between them, UNDECIDED), kind (uint8), clear_until (float64: certified, no contact before), grazes_until (float64:
from clear_until on, they only graze until then), contact_by (float64: they
meet at this time; infinite: never), gap (float64, metres: upper bound of the distance at clear_until), separating
(bool: in contact at 0, apart soon after), steps (int32), triangle_a, cell_a, triangle_b, cell_b, ends (float64 (2, 3)):
two parts that meet at contact_by, as in contacts(), normal (float64 (3,): separates a from b just before; 0: unknown).)");
    world.def(
        "cast_model", &cast_model, "model"_a, "starts"_a, "ends"_a, "layer"_a = 1, "mask"_a = all, "group"_a = 0,
        "path"_a = "linear", "time_tolerance"_a = usual.time_tolerance, "gap_tolerance"_a = usual.gap_tolerance,
        "most_steps"_a = usual.most_steps, "stop"_a = std::string(name_of(usual.stop)),
        R"(cast_model(self, model, starts, ends, layer=1, mask=4294967295, group=0, path="linear", time_tolerance=0.0001, gap_tolerance=0.0001, most_steps=10000, stop="contact")
--

The first contact of a moving model with the bodies at their poses, for many motions, on the World's threads. For a
planner, clear_until is the last valid time of an edge. starts, ends: poses as in sweep().

Returns a structured array (N,): body (uint64; 0: no contact), and the fields of sweep().)");
}

} // namespace oncollide::python
