// Queries of pairs: two sides, or many.
#include "sides.hpp"

namespace oncollide::python {

namespace {

/// Calls query(pairs, a, b, options...) for one pair, and query(pairs, many, options..., results) for many.
template <class Result, class Query, class... Options>
py::object results(PairsView& view, const char* call, py::handle a, py::handle b, Query query,
                   const Options&... options)
{
    Sides sides(call, a, b);
    if (sides.one())
        return scalar(computed(*view.held, call, false, [&](const World& w) {
            return query(w.pairs(), sides.a().only(), sides.b().only(), options...);
        }));
    return array_of(computed(*view.held, call, true, [&](const World& w) {
        std::vector<Result> found(sides.size());
        query(w.pairs(), sides.pairs(w), options..., std::span(found));
        return found;
    }));
}

/// The same for lists.
template <class Item, class Query, class... Options>
py::object lists(PairsView& view, const char* call, py::handle a, py::handle b, Query query, const Options&... options)
{
    Sides sides(call, a, b);
    if (sides.one())
        return array_of(computed(*view.held, call, false, [&](const World& w) {
            return query(w.pairs(), sides.a().only(), sides.b().only(), options...);
        }));
    return lists_of(computed(*view.held, call, true, [&](const World& w) {
        Lists<Item> found;
        query(w.pairs(), sides.pairs(w), options..., found);
        return found;
    }));
}

py::object sweep(PairsView& view, py::handle a, py::handle b, py::handle path, py::handle time, py::handle gap,
                 py::handle steps, py::handle stop)
{
    const char* const call = "pairs.sweep";
    const Sides sides(call, a, b, true);
    const MotionPath along = motion_path(path, {call, "path"});
    const SweepOptions options = sweep_options(time, gap, steps, stop, call);
    std::vector<SweepResult> found = computed(*view.held, call, true, [&](const World& w) {
        std::vector<PairOf<MovingModel>> pairs;
        for (std::size_t i = 0; i < sides.size(); ++i)
            pairs.push_back({sides.a().moving(w, i, along), sides.b().moving(w, i, along)});
        std::vector<SweepResult> results(pairs.size());
        w.pairs().sweep(pairs, options, results);
        return results;
    });
    if (sides.one()) return scalar(found.front());
    return array_of(std::move(found));
}

py::tuple manifold(PairsView& view, py::handle a, py::handle b, py::handle margin, py::handle normal_spread,
                   py::handle points_per_region, py::handle regions_per_pair, py::handle points_per_pair,
                   py::handle points_in_all, py::handle measures)
{
    const char* const call = "pairs.manifold";
    Sides sides(call, a, b);
    const ManifoldOptions options = manifold_options(margin, normal_spread, points_per_region, regions_per_pair,
                                                     points_per_pair, points_in_all, measures, call);
    if (sides.one()) {
        Manifold found = computed(*view.held, call, false, [&](const World& w) {
            return w.pairs().manifold(sides.a().only(), sides.b().only(), options);
        });
        return py::make_tuple(array_of(std::move(found.regions)), array_of(std::move(found.points)), found.complete);
    }
    ManifoldLists found = computed(*view.held, call, true, [&](const World& w) {
        ManifoldLists lists;
        w.pairs().manifold(sides.pairs(w), options, lists);
        return lists;
    });
    return py::make_tuple(array_of(std::move(found.regions)), array_of(std::move(found.points)),
                          offsets_of(found.offsets), array_of(py::dtype("?"), std::move(found.complete)));
}

} // namespace

void bind_pairs(py::module_& m)
{
    using namespace py::literals;
    py::class_<PairsView> pairs(m, "Pairs", R"(Queries of two sides, or of many pairs, as World.pairs.

    world.pairs.distance(body, other)                        # two bodies
    world.pairs.decide((robot, poses), (room, None))         # a model at many poses, and a model at one

A side is the id of a body, ids (N,), or a tuple (model, pose) for a body that the World does not hold; its model may be
many, too: a sequence of Models, or a uint64 array of int(model). Two sides of one entry have one result; otherwise the
result is an array, and a side of one entry serves all. Poses that are (N, 4, 4), C-contiguous and float64 are not copied, and a uint64 array of
models neither. Results do not depend on the number of threads, or on the other pairs of a call. Layers, groups and
exclusions do not matter here. Raises ValueError for other shapes and lengths, Error naming the pair that is refused.)");
    pairs.def(py::init<HeldWorld&>());
    refuse_pickles(pairs, "Pairs", "they are of one World");
    const SharedArguments with;
    define(
        pairs, "decide",
        [](PairsView& view, py::handle a, py::handle b) {
            return results<Finding>(view, "pairs.decide", a, b,
                                    [](const Pairs& all, auto&&... of) { return all.decide(of...); });
        },
        R"(The verdict on a pair now, as step() would give it.

Structured: verdict (uint8, a Verdict), kind (uint8, a ContactKind), bound (float64, metres; separate: certified lower
bound on the distance; within and undecided: certified upper bound; colliding: 0).)",
        "a"_a, "b"_a);
    define(
        pairs, "distance",
        [](PairsView& view, py::handle a, py::handle b, py::handle tolerance, py::handle cutoff) {
            const char* const call = "pairs.distance";
            return results<Distance>(
                view, call, a, b, [](const Pairs& all, auto&&... of) { return all.distance(of...); },
                distance_options(tolerance, cutoff, call));
        },
        R"(Certified bounds on the distance, and the nearest points.

tolerance: metres, >= 0; a larger tolerance is cheaper. cutoff: metres; beyond it lower > cutoff and upper = inf; None: no
cutoff.
Structured: lower, upper (float64, metres; both 0 if they meet), triangle_a, cell_a, triangle_b, cell_b (as in
contacts()), point_a, point_b (float64 (3,), world frame, if upper is finite).)",
        "a"_a, "b"_a, "tolerance"_a = 0.0, "cutoff"_a = py::none());
    define(
        pairs, "contacts",
        [](PairsView& view, py::handle a, py::handle b) {
            return lists<Contact>(view, "pairs.contacts", a, b,
                                  [](const Pairs& all, auto&&... of) { return all.contacts(of...); });
        },
        R"(All pairs of parts of the two sides that meet.

Structured (N,): triangle_a, triangle_b (uint32, indices of triangles; 0 for other parts), cell_a, cell_b (int32 (4,): for
maps the cube's x, y, z and side, in cells), kind (uint8, a ContactKind), ends (float64 (2, 3): for two triangles the
segment that both share, else a point on each part), normal_a, normal_b (float64 (3,), unit). World frame, metres. For
many pairs (contacts, offsets).)",
        "a"_a, "b"_a);
    define(
        pairs, "penetration",
        [](PairsView& view, py::handle a, py::handle b) {
            return results<Penetration>(view, "pairs.penetration", a, b,
                                        [](const Pairs& all, auto&&... of) { return all.penetration(of...); });
        },
        R"(How deep the deepest point of one side lies inside the other, from its surface.

It takes all kinds of bodies; a terrain is solid below its surface. Structured: supported (bool: False for two terrains and for cooked
meshes read on demand), depth and depth_upper (float64, metres: certified bounds; both 0 where the two are apart), deepest
(float64 (3,), a point that is depth deep), of_a (bool, it is a point of a). For two sides with triangles (meshes, boxes,
hulls) depth is the depth of a vertex, and these are set: contact, overlap (float64 (2, 3): corners of a box around the
contact curve, and around the overlap), vertex (uint32, the index of the deepest), thickness (float64, metres: the overlap
lies between two planes this far apart), thin_along (float64 (3,), unit normal of these planes),
parting_lower, parting_upper, parting_along (two shapes: certified bounds of the least translation that parts them, and
its direction from a to b; others: 0, infinite, 0).)",
        "a"_a, "b"_a);
    define(pairs, "sweep", &sweep,
           R"(When two sides first meet, of which one moves or both, over the time from 0 to 1.

a, b: as in the other calls, or a tuple (model, start, end) for a model that moves from one pose to another. path: "linear"
(the origin in a straight line, the rotation along the shorter arc) or "screw". stop: "contact" (the first certain
contact; a gap that rounding hides is passed), "touch" (such a gap, too) or "press" (the first contact that gets deeper
than gap_tolerance, metres; bodies may touch, slide along each other, and part). time_tolerance: of the time of contact.
most_steps: windows of time to examine.

Structured: verdict (uint8: SEPARATE, COLLIDING, WITHIN where only a clearance or rounding is between them, UNDECIDED),
kind (uint8), clear_until (float64: certified, no contact before), grazes_until (float64: from clear_until on, they only
graze until then), contact_by (float64: they meet at this time; infinite: never), gap (float64, metres: upper bound of the
distance at clear_until), separating (bool: in contact at 0, apart soon after), steps (int32), triangle_a, cell_a,
triangle_b, cell_b, ends (float64 (2, 3)): two parts that meet at contact_by, as in contacts(), normal (float64 (3,):
separates a from b just before; 0: unknown).)",
           "a"_a, "b"_a, with.path, with.time_tolerance, with.gap_tolerance, with.most_steps, with.stop);
    define(pairs, "manifold", &manifold,
           R"(Reduces the contacts to regions for a solver, with few points each.

margin: metres; parts of surfaces this near are regions, too. normal_spread: radians; faces of one region differ by at
most twice this. points_per_region, regions_per_pair, points_per_pair: at least 1; regions share the points of a pair in
turn, the deepest first. points_in_all: limit of the points of all pairs, which share them in turn; 0: no limit.
measures: find area, volume, centre and lost, which solvers do not use; else they are NaN.

Returns (regions, points, complete); for many pairs (regions, points, offsets, complete), and complete is bool (N,).
regions: structured, the deepest first: kind (uint8: 0 crossing, 1 touching, 2 enclosed, 3 near), open (bool: a surface is
not closed), normal (float64 (3,), unit, from a to b), normal_error (radians; pi where no normal has a meaning), area,
volume, centre (3,), depth_lower, depth_upper (certified), lost (no common point of both surfaces is farther than this from
the hull of the points), first, count (its points), found (candidates before the reduction). points: point_a, point_b (float64 (3,)),
depth (> 0 inside), depth_error, feature_a, feature_b (uint64), normal (3,) (unit: across the faces at the point, or the
region's). complete: False if a limit left out a region or a point, or the pair has no manifold. World frame, metres.)",
           "a"_a, "b"_a, with.margin, with.normal_spread, with.points_per_region, with.regions_per_pair,
           with.points_per_pair, with.points_in_all, with.measures);
    define(
        pairs, "near_features",
        [](PairsView& view, py::handle a, py::handle b, py::handle dhat) {
            const char* const call = "pairs.near_features";
            return lists<NearFeatures>(
                view, call, a, b, [](const Pairs& all, auto&&... of) { return all.near_features(of...); },
                number(dhat, {call, "dhat"}));
        },
        R"(All pairs of a vertex and a face, or of two edges, at most `dhat` metres apart, of two sides with triangles.

Structured (N,): a, b (uint64 features, as in manifold()), lower, upper (float64, certified bounds of the distance),
point_a, point_b (float64 (3,)). For many pairs (features, offsets).)",
        "a"_a, "b"_a, "dhat"_a);
    define(
        pairs, "max_error",
        [](PairsView& view, py::handle a, py::handle b) {
            const char* const call = "pairs.max_error";
            const Sides sides(call, a, b);
            if (!sides.one()) refuse_value({call, "a"}, "expected one pair");
            const Looking looking(*view.held, call);
            return view.held->world.pairs().max_error(sides.a().only(), sides.b().only());
        },
        "The error bound of `within` for one pair, metres above the clearance (float).", "a"_a, "b"_a);
}

} // namespace oncollide::python
