#include <oncollide/narrowphase/pairs/pair_tests.hpp>

#include <array>
#include <concepts>

#include <oncollide/narrowphase/pairs/closed_forms.hpp>
#include <oncollide/narrowphase/pairs/depth_bounds.hpp>
#include <oncollide/narrowphase/pairs/direct_tests.hpp>
#include <oncollide/narrowphase/pairs/manifold_tests.hpp>
#include <oncollide/narrowphase/pairs/surface_tests.hpp>
#include <oncollide/narrowphase/pairs/sweep_tests.hpp>
#include <oncollide/narrowphase/pairs/walk_tests.hpp>

namespace oncollide {

namespace pair_table {

using direct_tests::half_space_depth, direct_tests::OnHalfSpace, direct_tests::TwoShapes;
using operand::Cells, operand::Heights, operand::Plane, operand::Polytope, operand::Solid, operand::Triangles;
using walk_tests::WalkPair, walk_tests::walk_pair;

using Contacts = std::vector<Contact>;

// Makers of rows. `swapped`: the pair's b is the first operand, in whose frame the test computes.

/// Two bodies with triangles.
template <class A, class B>
constexpr PairTests surfaces()
{
    return {.trees = TreesNeeded::always,
            .decide = surface_tests::decide<A, B>,
            .near = surface_tests::near<A, B>,
            .distance =
                [](PairWorker& worker, const PairTask& task, const DistanceOptions& options, bool solid) {
                    const Distance found = surface_tests::distance<A, B>(worker, task, options);
                    return walk_tests::with_insides(found, worker, task, solid);
                },
            .direct_distance = nullptr,
            .contacts = surface_tests::contacts<A, B>,
            .penetration = nullptr,
            .advance = sweep_tests::surfaces<A, B>,
            .manifold = manifold_of,
            .near_features = nullptr};
}

/// Two bodies whose hierarchies have a walk.
template <class A, class B, bool swapped>
constexpr PairTests walked()
{
    return {.trees = TreesNeeded::always,
            .decide =
                [](PairWorker& worker, const PairTask& task, const PairOptions& options, PairMemory* memory) {
                    return walk_tests::decide(walk_pair<A, B>(worker, task, swapped), options.clearance, memory);
                },
            .near =
                [](PairWorker& worker, const PairTask& task, double clearance, double tolerance, PairMemory* memory) {
                    return walk_tests::near(walk_pair<A, B>(worker, task, swapped), clearance, tolerance, memory);
                },
            .distance =
                [](PairWorker& worker, const PairTask& task, const DistanceOptions& options, bool solid) {
                    const Distance found = walk_tests::distance(walk_pair<A, B>(worker, task, swapped), options);
                    return walk_tests::with_insides(found, worker, task, solid);
                },
            .direct_distance = nullptr,
            .contacts = [](PairWorker& worker, const PairTask& task,
                           Contacts& found) { walk_tests::contacts(WalkPair<A, B>(worker, task, swapped), found); },
            .penetration = nullptr,
            .advance = sweep_tests::walked<A, B, swapped>,
            .manifold = manifold_of,
            .near_features = nullptr};
}

/// The distance of a shape from a mesh or a terrain, B: of the shape as a solid, or of its surface if it has too many
/// points.
template <class Shape, class B, bool swapped>
Distance shape_distance(PairWorker& worker, const PairTask& task, const DistanceOptions& options, bool solid)
{
    const OrderedPair pair(task, swapped);
    const auto walk = [&] {
        if constexpr (std::same_as<Shape, Polytope> && swapped) // surfaces are not swapped
            return walk_tests::distance(walk_pair<B, Shape>(worker, task, false), options);
        else
            return walk_tests::distance(walk_pair<Shape, B>(worker, task, swapped), options);
    };
    const Distance found =
        pair.a.convex().count <= operand::most_points ? walk_tests::solid_distance<B>(worker, pair, options) : walk();
    return walk_tests::with_insides(found, worker, task, solid);
}

template <class B, bool swapped>
constexpr PairTests round_and_surface()
{
    PairTests tests = walked<Solid, B, swapped>();
    tests.distance = shape_distance<Solid, B, swapped>;
    return tests;
}

/// Triangles decide; as a solid, a box or a hull is nearer to other bodies, and has one contact for each triangle.
template <class B, bool swapped>
constexpr PairTests polytope_and_surface()
{
    PairTests tests = [] {
        if constexpr (swapped)
            return surfaces<B, Polytope>();
        else
            return surfaces<Polytope, B>();
    }();
    tests.distance = shape_distance<Polytope, B, swapped>;
    tests.contacts = walked<Solid, B, swapped>().contacts;
    return tests;
}

template <bool swapped>
constexpr PairTests map_and_polytope()
{
    PairTests tests = walked<Cells, Polytope, swapped>();
    tests.contacts = walked<Cells, Solid, swapped>().contacts;
    return tests;
}

/// Two shapes are taken in an order that does not depend on which of them is called a, so that all columns agree on
/// whether they meet: rounding in the other frame could give another result.
template <class Test, bool swapped>
Test test_of(const PairTask& task)
{
    return Test(task, std::same_as<Test, TwoShapes> ? decides_b_first(task) : swapped);
}

template <class Test, bool swapped>
constexpr PairTests direct(TreesNeeded trees)
{
    return {.trees = trees,
            .decide =
                [](PairWorker&, const PairTask& task, const PairOptions& options, PairMemory* memory) {
                    const Test test = test_of<Test, swapped>(task);
                    if (direct_tests::overlap(test, task, memory)) return Finding{Verdict::colliding, {}, 0};
                    return direct_tests::decide(test, options.clearance);
                },
            .near =
                [](PairWorker&, const PairTask& task, double clearance, double tolerance, PairMemory* memory) {
                    const Test test = test_of<Test, swapped>(task);
                    if (direct_tests::overlap(test, task, memory)) return bodies_overlap;
                    return direct_tests::compare(test, clearance, {.below = clearance + tolerance},
                                                 ContactKind::unknown);
                },
            .distance = [](PairWorker&, const PairTask& task, const DistanceOptions& options,
                           bool) { return direct_tests::distance(test_of<Test, swapped>(task), options); },
            .direct_distance =
                trees == TreesNeeded::always
                    ? nullptr
                    : +[](const PairTask& task,
                          const DistanceOptions&
                              options) { return direct_tests::distance(test_of<Test, swapped>(task), options); },
            .contacts = [](PairWorker&, const PairTask& task,
                           Contacts& found) { direct_tests::contacts(test_of<Test, swapped>(task), found); },
            .penetration = nullptr,
            .advance = sweep_tests::direct<Test, swapped>,
            .manifold = manifold_of,
            .near_features = nullptr};
}

constexpr PairTests two_planes()
{
    return direct<OnHalfSpace<Plane>, false>(TreesNeeded::never);
}

/// Two bodies of one kind, each of which the test may take first: both orders of a pair are decided equally.
template <PairTests (*row)()>
constexpr PairTests in_one_order()
{
    PairTests tests = row();
    tests.decide = [](PairWorker& worker, const PairTask& task, const PairOptions& options, PairMemory* memory) {
        return row().decide(worker, decides_b_first(task) ? task.swapped() : task, options, memory);
    };
    tests.distance = [](PairWorker& worker, const PairTask& task, const DistanceOptions& options, bool solid) {
        const bool b_first = decides_b_first(task);
        return in_task(row().distance(worker, b_first ? task.swapped() : task, options, solid), b_first);
    };
    return tests;
}

/// Two shapes, of which at most one is a box or a hull.
constexpr PairTests two_shapes()
{
    PairTests tests = direct<TwoShapes, false>(TreesNeeded::never);
    tests.decide = [](PairWorker& worker, const PairTask& task, const PairOptions& options, PairMemory* memory) {
        if (const std::optional<Finding> found = decide_by_centre(task, options.clearance)) return *found;
        return direct<TwoShapes, false>(TreesNeeded::never).decide(worker, task, options, memory);
    };
    return tests;
}

/// A half-space and a shape.
template <bool swapped>
constexpr PairTests half_space_and_shape()
{
    PairTests tests = direct<OnHalfSpace<Solid>, swapped>(TreesNeeded::never);
    tests.decide = [](PairWorker& worker, const PairTask& task, const PairOptions& options, PairMemory* memory) {
        if (const std::optional<Finding> found = decide_by_height(task, swapped, options.clearance)) return *found;
        return direct<OnHalfSpace<Solid>, swapped>(TreesNeeded::never).decide(worker, task, options, memory);
    };
    tests.penetration = half_space_depth<Solid, swapped>;
    return tests;
}

/// Two boxes or hulls: their triangles decide kinds of contact only.
constexpr PairTests two_polytopes()
{
    PairTests tests = direct<TwoShapes, false>(TreesNeeded::for_kinds);
    tests.decide = [](PairWorker& worker, const PairTask& task, const PairOptions& options, PairMemory* memory) {
        if (options.kinds) return surface_tests::decide<Polytope, Polytope>(worker, task, options, memory);
        double depth = 0;
        if (const std::optional<Finding> found = decide_by_axes(task, options.clearance, depth)) {
            if (memory && depth > 0) memory->meet(depth, task.travel);
            return *found;
        }
        return direct<TwoShapes, false>(TreesNeeded::never).decide(worker, task, options, memory);
    };
    return tests;
}

using Table = std::array<std::array<PairTests, kind_count>, kind_count>;

constexpr Table make_table()
{
    Table table{};
    const auto at = [&](Kind a, Kind b) -> PairTests& { return table[std::size_t(a)][std::size_t(b)]; };
    using enum Kind;
    at(mesh, mesh) = surfaces<Triangles, Triangles>();
    at(mesh, terrain) = surfaces<Triangles, Heights>(), at(terrain, mesh) = surfaces<Heights, Triangles>();
    at(terrain, terrain) = surfaces<Heights, Heights>();

    at(map, map) = in_one_order<walked<Cells, Cells, false>>();
    at(map, mesh) = walked<Cells, Triangles, false>(), at(mesh, map) = walked<Cells, Triangles, true>();
    at(map, terrain) = walked<Cells, Heights, false>(), at(terrain, map) = walked<Cells, Heights, true>();
    at(map, polytope) = map_and_polytope<false>(), at(polytope, map) = map_and_polytope<true>();
    at(map, round) = walked<Cells, Solid, false>(), at(round, map) = walked<Cells, Solid, true>();

    at(polytope, mesh) = polytope_and_surface<Triangles, false>();
    at(mesh, polytope) = polytope_and_surface<Triangles, true>();
    at(polytope, terrain) = polytope_and_surface<Heights, false>();
    at(terrain, polytope) = polytope_and_surface<Heights, true>();
    at(round, mesh) = round_and_surface<Triangles, false>(), at(mesh, round) = round_and_surface<Triangles, true>();
    at(round, terrain) = round_and_surface<Heights, false>(), at(terrain, round) = round_and_surface<Heights, true>();

    at(polytope, polytope) = two_polytopes();
    at(round, round) = at(round, polytope) = at(polytope, round) = two_shapes();

    const auto on_half_space = [&]<class Body>(Body, Kind body, TreesNeeded trees) {
        at(half_space, body) = direct<OnHalfSpace<Body>, false>(trees);
        at(body, half_space) = direct<OnHalfSpace<Body>, true>(trees);
        at(half_space, body).penetration = half_space_depth<Body, false>;
        at(body, half_space).penetration = half_space_depth<Body, true>;
    };
    on_half_space(Triangles(), mesh, TreesNeeded::always);
    on_half_space(Heights(), terrain, TreesNeeded::always);
    on_half_space(Cells(), map, TreesNeeded::always);
    at(half_space, polytope) = at(half_space, round) = half_space_and_shape<false>();
    at(polytope, half_space) = at(round, half_space) = half_space_and_shape<true>();
    at(half_space, half_space) = in_one_order<two_planes>();
    at(half_space, half_space).penetration = half_space_depth<Plane, false>;
    at(half_space, half_space).manifold = nullptr;

    for (const Kind a : {mesh, terrain, map, polytope, round})
        for (const Kind b : {mesh, terrain, map, polytope, round})
            if (a != terrain || b != terrain) at(a, b).penetration = depth_of_bounded;
    for (const Kind a : {mesh, polytope})
        for (const Kind b : {mesh, polytope}) at(a, b).penetration = surface_tests::penetration;
    for (const Kind a : {mesh, terrain, polytope})
        for (const Kind b : {mesh, terrain, polytope}) at(a, b).near_features = near_features_of;
    return table;
}

} // namespace pair_table

const PairTests& tests_for(Kind a, Kind b)
{
    static constexpr pair_table::Table table = pair_table::make_table();
    return table[std::size_t(a)][std::size_t(b)];
}

} // namespace oncollide
