// Queries of one thing against all bodies of a World, or of many things.
#include "held_world.hpp"

namespace oncollide::python {

namespace {

/// The things that a query tests against all bodies: one, or many.
template <class Thing>
struct Things {
    std::vector<Thing> all;
    bool one;
};

Things<PlacedModel> placed(py::handle model, py::handle at, const char* call)
{
    const ModelId id = model_of(model, {call, "model"});
    const Poses poses(at, {call, "pose"});
    Things<PlacedModel> made{std::vector<PlacedModel>(poses.size(), PlacedModel{id}), poses.one()};
    for (std::size_t i = 0; i < poses.size(); ++i) made.all[i].pose = poses[i];
    return made;
}

Things<MovingModel> moving(py::handle model, py::handle from, py::handle to, py::handle path, const char* call)
{
    const ModelId id = model_of(model, {call, "model"});
    const MotionPath along = motion_path(path, {call, "path"});
    const Poses starts(from, {call, "start"}), ends(to, {call, "end"});
    Lengths lengths(call);
    lengths.add("start", starts.one(), starts.size()), lengths.add("end", ends.one(), ends.size());
    Things<MovingModel> made{{}, lengths.one()};
    for (std::size_t i = 0; i < lengths.size(); ++i) made.all.push_back({id, RigidMotion(starts[i], ends[i], along)});
    return made;
}

/// From two points, (3,), or two columns of points, (N, 3).
template <class Thing>
Things<Thing> of_points(py::handle first, const char* first_name, py::handle second, const char* second_name,
                        const char* call)
{
    const Points a(first, {call, first_name}), b(second, {call, second_name});
    Lengths lengths(call);
    lengths.add(first_name, a.one(), a.size()), lengths.add(second_name, b.one(), b.size());
    Things<Thing> made{{}, lengths.one()};
    for (std::size_t i = 0; i < lengths.size(); ++i) made.all.push_back({a[i], b[i]});
    return made;
}
Things<Segment> segments(py::handle start, py::handle end, const char* call)
{
    return of_points<Segment>(start, "start", end, "end", call);
}
Things<Aabb> boxes(py::handle low, py::handle high, const char* call)
{
    return of_points<Aabb>(low, "low", high, "high", call);
}

/// The list that query(space, thing) returns, or many: query(space, things, lists) sets them.
template <class Item, class Thing, class Query>
py::object lists(SpaceView& view, const char* call, const Things<Thing>& things, Query query)
{
    if (things.one)
        return array_of(
            computed(*view.held, call, false, [&](const World& w) { return query(w.space(), things.all[0]); }));
    return lists_of(computed(*view.held, call, true, [&](const World& w) {
        Lists<Item> found;
        query(w.space(), std::span(things.all), found);
        return found;
    }));
}

/// The result that query(space, thing) returns, or many: query(space, things, results) sets them.
template <class Result, class Thing, class Query>
py::object results(SpaceView& view, const char* call, const Things<Thing>& things, Query query)
{
    if (things.one)
        return scalar(
            computed(*view.held, call, false, [&](const World& w) { return query(w.space(), things.all[0]); }));
    return array_of(computed(*view.held, call, true, [&](const World& w) {
        std::vector<Result> found(things.all.size());
        query(w.space(), std::span(things.all), std::span(found));
        return found;
    }));
}

/// A method with two arguments, of which make(first, second, call) makes things, and a filter.
template <class Make, class Work>
auto filtered(const char* call, Make make, Work work)
{
    return [call, make, work](SpaceView& view, py::handle first, py::handle second, py::handle layer, py::handle mask,
                              py::handle group) {
        const CollisionFilter filter = filter_of(layer, mask, group, call);
        return work(view, call, make(first, second, call), filter);
    };
}

constexpr auto overlaps = [](SpaceView& view, const char* call, const auto& things, const CollisionFilter& filter) {
    return lists<QueryHit>(view, call, things, [&](const Space& space, const auto& of, auto&... found) {
        return space.overlaps(of, filter, found...);
    });
};
constexpr auto cast = [](SpaceView& view, const char* call, const auto& things, const CollisionFilter& filter) {
    return results<CastHit>(view, call, things, [&](const Space& space, const auto& of, auto... found) {
        return space.cast(of, filter, found...);
    });
};
constexpr auto cast_all = [](SpaceView& view, const char* call, const auto& things, const CollisionFilter& filter) {
    return lists<CastHit>(view, call, things, [&](const Space& space, const auto& of, auto&... found) {
        return space.cast_all(of, filter, found...);
    });
};

py::object cast_model(SpaceView& view, py::handle model, py::handle from, py::handle to, py::handle layer,
                      py::handle mask, py::handle group, py::handle path, py::handle time, py::handle gap,
                      py::handle steps, py::handle stop)
{
    const char* const call = "space.cast_model";
    const CollisionFilter filter = filter_of(layer, mask, group, call);
    const SweepOptions options = sweep_options(time, gap, steps, stop, call);
    return results<SweepHit>(
        view, call, moving(model, from, to, path, call),
        [&](const Space& space, const auto& of, auto... found) { return space.cast(of, filter, options, found...); });
}

py::object cast_all_model(SpaceView& view, py::handle model, py::handle from, py::handle to, py::handle layer,
                          py::handle mask, py::handle group, py::handle path, py::handle time, py::handle gap,
                          py::handle steps, py::handle stop)
{
    const char* const call = "space.cast_all_model";
    const CollisionFilter filter = filter_of(layer, mask, group, call);
    const SweepOptions options = sweep_options(time, gap, steps, stop, call);
    return lists<SweepHit>(view, call, moving(model, from, to, path, call),
                           [&](const Space& space, const auto& of, auto&... found) {
                               return space.cast_all(of, filter, options, found...);
                           });
}

py::object distances(SpaceView& view, py::handle model, py::handle at, py::handle cutoff, py::handle tolerance,
                     py::handle layer, py::handle mask, py::handle group)
{
    const char* const call = "space.distances";
    const CollisionFilter filter = filter_of(layer, mask, group, call);
    const DistanceOptions options = distance_options(tolerance, cutoff, call);
    return lists<BodyDistance>(view, call, placed(model, at, call),
                               [&](const Space& space, const auto& of, auto&... found) {
                                   return space.distances(of, filter, options, found...);
                               });
}

} // namespace

void bind_space(py::module_& m)
{
    using namespace py::literals;
    py::class_<SpaceView> space(m, "Space", R"(Queries of one thing against all bodies, as World.space.

    world.space.overlaps(model, pose)          # a model at a pose, or at poses (N, 4, 4)
    world.space.cast(start, end)               # a segment, or segments: points (N, 3)
    world.space.cast_model(model, start, end)  # a model that moves

layer, mask, group: as of a body that the thing would be; see bodies.add().)");
    space.def(py::init<HeldWorld&>());
    refuse_pickles(space, "Space", "it is of one World");
    const SharedArguments with;
    define(space, "overlaps", filtered("space.overlaps", &placed, overlaps),
           R"(The bodies that a body of this model at this pose would hit, without adding it.

Structured (N,), sorted by slot: body (uint64), verdict (uint8, never separate), kind (uint8), bound (float64, metres). For
many poses (hits, offsets).)",
           "model"_a, "pose"_a = py::none(), with.layer, with.mask, with.group);
    define(space, "overlaps_segment", filtered("space.overlaps_segment", &segments, overlaps),
           R"(The bodies that a segment touches. start, end: (3,) metres, or (N, 3).

Returns as overlaps(), not sorted along the segment. For meshes, terrains, maps, boxes and hulls the result is exact with
all settings.)",
           "start"_a, "end"_a, with.layer, with.mask, with.group);
    define(space, "overlaps_box", filtered("space.overlaps_box", &boxes, overlaps),
           R"(The bodies that touch a solid box along the world's axes. low, high: (3,) metres, its corners, or (N, 3).

Returns as overlaps().)",
           "low"_a, "high"_a, with.layer, with.mask, with.group);
    define(space, "cast", filtered("space.cast", &segments, cast),
           R"(The first body that a segment hits, and where. start, end: (3,) metres, or (N, 3).

Structured: body (uint64; 0: nothing is hit), verdict (uint8: COLLIDING; WITHIN where rounding hides whether a round shape
is touched; UNDECIDED if a file or a budget prevents the test), fraction_lower and fraction_upper (float64: certified
bounds of the fraction of the segment), point and normal (float64 (3,), world; the normal faces the start, 0 where it is
not defined), triangle (uint32), cell (int32 (4,)).)",
           "start"_a, "end"_a, with.layer, with.mask, with.group);
    define(space, "cast_all", filtered("space.cast_all", &segments, cast_all),
           R"(The first point of a segment in each body that it hits, sorted along the segment.

Structured (N,), as cast(); for many segments (hits, offsets).)",
           "start"_a, "end"_a, with.layer, with.mask, with.group);
    define(space, "cast_model", &cast_model,
           R"(The first contact of a moving model with the bodies at their poses. start, end: poses, or many.

Structured: body (uint64; 0: no contact), and the fields of pairs.sweep(), which explains the options. clear_until is
certified for all bodies: for a planner, the last valid time of an edge.)",
           "model"_a, "start"_a, "end"_a, with.layer, with.mask, with.group, with.path, with.time_tolerance,
           with.gap_tolerance, with.most_steps, with.stop);
    define(space, "cast_all_model", &cast_all_model,
           R"(The first contact with each body, sorted by clear_until.

Structured (N,), as cast_model(); for many motions (hits, offsets).)",
           "model"_a, "start"_a, "end"_a, with.layer, with.mask, with.group, with.path, with.time_tolerance,
           with.gap_tolerance, with.most_steps, with.stop);
    define(space, "distances", &distances,
           R"(The bodies at most `cutoff` metres (finite) from a model at a pose, and their distances.

Structured (N,), sorted by slot: body (uint64), and the fields of pairs.distance(), which explains `tolerance`. For many
poses (found, offsets).)",
           "model"_a, "pose"_a, "cutoff"_a, "tolerance"_a = 0.0, with.layer, with.mask, with.group);
}

} // namespace oncollide::python
