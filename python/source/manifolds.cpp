// The manifolds of a frame, and the tracker of their points.
#include <fmt/format.h>

#include <oncollide/pipeline/manifold_tracker.hpp>

#include "held_world.hpp"

namespace oncollide::python {

namespace {

/// A copy of the manifolds of a frame, which the World will overwrite.
struct ManifoldsResult : FrameManifolds {
    using InModule = void;
};

std::unique_ptr<ManifoldsResult> manifolds(HeldWorld& held, py::handle margin, py::handle normal_spread,
                                           py::handle points_per_region, py::handle regions_per_pair,
                                           py::handle points_per_pair, py::handle points_in_all, py::handle measures)
{
    const char* const call = "World.manifolds";
    const ManifoldOptions options = manifold_options(margin, normal_spread, points_per_region, regions_per_pair,
                                                     points_per_pair, points_in_all, measures, call);
    std::unique_ptr<ManifoldsResult> result;
    {
        const Inside inside(held, call);
        const Released released(&held.interrupts);
        result = std::make_unique<ManifoldsResult>(ManifoldsResult{held.world.manifolds(options)});
        result_type<ManifoldRegion>().clear_gaps(result->regions.data(), result->regions.size());
        result_type<ManifoldPoint>().clear_gaps(result->points.data(), result->points.size());
    }
    held.interrupts.rethrow();
    return result;
}

/// The tracker in Python.
struct TrackerHandle {
    using InModule = void;
    ManifoldTracker tracker;
    explicit TrackerHandle(double match_distance) : tracker(match_distance) {}
};

/// @returns (previous, ids, ended)
py::tuple update(TrackerHandle& handle, HeldWorld& held, const ManifoldsResult& manifolds)
{
    const ManifoldTracker::Update* update = nullptr;
    {
        const Looking looking(held, "ManifoldTracker.update");
        update = &handle.tracker.update(held.world, manifolds.pairs, manifolds);
    }
    std::vector<std::int64_t> previous;
    for (const std::uint32_t p : update->previous)
        previous.push_back(p == ManifoldTracker::none ? -1 : static_cast<std::int64_t>(p));
    return py::make_tuple(array_of(py::dtype("i8"), std::move(previous)), array_of(py::dtype("u8"), update->ids),
                          array_of(py::dtype("u4"), update->ended));
}

} // namespace

void bind_manifolds(py::module_& m, WorldClass& world)
{
    using namespace py::literals;
    py::class_<ManifoldsResult> result(m, "Manifolds", R"(The manifolds of a frame, as World.manifolds() returns them.

Later steps do not change its arrays. Regions offsets[i]:offsets[i + 1] belong to pair i, and name their points.)");
    refuse_pickles(result, "Manifolds", "pickle its arrays");
    result
        .def_property_readonly("pairs", &column<ManifoldsResult, &FrameManifolds::pairs>,
                               "The pairs that have a region, or whose manifold is not complete: structured (N,), a, b "
                               "(uint64), in the order of Frame.pairs.")
        .def_property_readonly("regions", &column<ManifoldsResult, &FrameManifolds::regions>,
                               "Structured (R,), the fields of World.pairs.manifold().")
        .def_property_readonly("points", &column<ManifoldsResult, &FrameManifolds::points>,
                               "Structured (P,), the fields of World.pairs.manifold().")
        .def_property_readonly(
            "offsets", [](const ManifoldsResult& r) { return offsets_of(r.offsets); }, "int64 (N + 1,).")
        .def_property_readonly(
            "complete",
            [](const ManifoldsResult& r) { return array_of(py::dtype("?"), std::vector<std::uint8_t>(r.complete)); },
            "bool (N,): False if a limit left out a region or a point, or the pair has no manifold.")
        .def("__repr__", [](const ManifoldsResult& r) {
            return fmt::format("<oncollide.Manifolds: {} pairs, {} regions, {} points>", r.pairs.size(),
                               r.regions.size(), r.points.size());
        });

    const SharedArguments with;
    define(world, "manifolds", &manifolds,
           R"(Returns the Manifolds of the last step's pairs that meet or are at most the margin apart, for a solver.

It takes the arguments of World.pairs.manifold(). Pairs whose bodies did not change since the step before are copied.
With a margin, the World needs a clearance of at least as much. Raises Error before the first step,
and if bodies or models changed since the last one.)",
           with.margin, with.normal_spread, with.points_per_region, with.regions_per_pair, with.points_per_pair,
           with.points_in_all, with.measures);

    py::class_<TrackerHandle> tracker(m, "ManifoldTracker", R"(ManifoldTracker(match_distance=0.01)
--

Finds the points of the last frame's manifolds in the new ones, so that a solver can keep their impulses.

Points of the same two bodies match if their features are equal, and otherwise if they are at most match_distance metres
apart in the frame of one of the bodies.)");
    refuse_pickles(tracker, "ManifoldTracker", "make a new one");
    tracker.def(py::init([](py::handle distance) {
                    return std::make_unique<TrackerHandle>(number(distance, {"ManifoldTracker", "match_distance"}));
                }),
                "match_distance"_a = 0.01);
    define(tracker, "update", &update,
           R"(Takes the manifolds of the next frame, from World.manifolds().

Returns (previous, ids, ended): for each point its index in the last frame or -1 (int64), and its id, kept while it lasts
(uint64); the indices of points of the last frame without a successor (uint32).)",
           "world"_a, "manifolds"_a);
}

} // namespace oncollide::python
