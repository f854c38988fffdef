// Which refiner takes a pair: the table in dispatch.hpp, budgets, and the trees that exist.
#include <gtest/gtest.h>

#include <oncollide/pipeline/refine/dispatch.hpp>
#include <oncollide/samples/generators.hpp>

#include "pipeline/refine/refined_models.hpp"

namespace oncollide::dispatch_test {
namespace {

using enum Kind;
using enum Refiner;
using test::RefinedModels;

constexpr Kind all_kinds[] = {mesh, terrain, map, polytope, round, half_space};
constexpr Kind with_spheres[] = {mesh, map, polytope, round};

/// The refiner of new models of these kinds.
Refiner refiner_of(const Settings& settings, Level level, Kind a, Kind b)
{
    RefinedModels models(settings);
    return Dispatch(settings).of(level, models.store, models.add(a), models.add(b), 0);
}

/// Expects the refiner in both orders.
void expect(Refiner refiner, const Settings& settings, Level level, Kind a, Kind b)
{
    SCOPED_TRACE(testing::Message() << "level " << int(level) << ", kinds " << int(a) << " and " << int(b));
    EXPECT_EQ(int(refiner_of(settings, level, a, b)), int(refiner));
    EXPECT_EQ(int(refiner_of(settings, level, b, a)), int(refiner));
}

TEST(Dispatch, FollowsItsTable)
{
    const Settings obbs_alone, spheres_alone{.depth = 5}, obb_exact{.exact = ExactLevel::predicates},
        sphere_exact{.exact = ExactLevel::predicates, .bounding_volume = BoundingVolume::sphere},
        by_fcl{.exact = ExactLevel::fcl, .bounding_volume = BoundingVolume::obb},
        exact_skipped{.exact = ExactLevel::predicates, .skip = {StageId::exact}};
    for (const Kind a : all_kinds)
        for (const Kind b : all_kinds) {
            const bool no_spheres = a == terrain || b == terrain || a == half_space || b == half_space;
            expect(obbs, obbs_alone, Level::refine, a, b);
            expect(no_spheres ? obbs : spheres, spheres_alone, Level::refine, a, b);
            expect(none, obb_exact, Level::refine, a, b);
            expect(no_spheres ? none : spheres, sphere_exact, Level::refine, a, b);
            expect(obbs, by_fcl, Level::refine, a, b);
            expect(obbs, exact_skipped, Level::refine, a, b);
            expect(exact, obb_exact, Level::exact, a, b);
            expect(exact, sphere_exact, Level::exact, a, b);
            expect(fcl, by_fcl, Level::exact, a, b);
        }
}

TEST(Dispatch, ABudgetWithoutRoomLeavesMeshesToSpheresAndNothingToTheExactLevel)
{
    const Settings settings{.exact = ExactLevel::predicates, .node_budget = 1};
    for (const Kind other : with_spheres) {
        expect(spheres, settings, Level::refine, mesh, other);
        expect(no_room, settings, Level::exact, mesh, other);
    }
    for (const Kind other : {terrain, half_space}) { // they have no sphere-tree
        expect(no_room, settings, Level::refine, mesh, other);
        expect(no_room, settings, Level::exact, mesh, other);
    }
    expect(none, settings, Level::refine, terrain, map); // the trees of grids are no OBB trees
    expect(exact, settings, Level::exact, terrain, map);
}

TEST(Dispatch, TwoShapesNeedNoRoomExceptForKindsOfContact)
{
    Settings settings{.exact = ExactLevel::predicates, .node_budget = 1};
    for (const Kind a : {polytope, round, half_space})
        for (const Kind b : {polytope, round, half_space}) {
            settings.contact_kinds = false;
            expect(exact, settings, Level::exact, a, b);
            settings.contact_kinds = true;
            expect(a == polytope && b == polytope ? no_room : exact, settings, Level::exact, a, b);
        }
}

TEST(Dispatch, TreesAreThereOnceTheyWereMadeForBothModels)
{
    const Settings settings{.exact = ExactLevel::predicates};
    RefinedModels models(settings);
    ModelStore& store = models.store;
    Model &a = models.add(mesh), &b = models.add(mesh), &box = models.add(polytope), &ball = models.add(round);
    const Dispatch dispatch(settings);
    for (const Level level : {Level::refine, Level::exact}) {
        EXPECT_FALSE(dispatch.there(level, store, a, b));
        EXPECT_TRUE(dispatch.there(level, store, box, ball)) << "they need no trees";
    }
    store.obb_tree(a, 0);
    EXPECT_FALSE(dispatch.there(Level::exact, store, a, b));
    EXPECT_FALSE(dispatch.there(Level::exact, store, b, a));
    dispatch.of(Level::exact, store, a, b, 0);
    EXPECT_TRUE(a.has_obb_tree() && b.has_obb_tree());
    for (const Level level : {Level::refine, Level::exact}) EXPECT_TRUE(dispatch.there(level, store, a, b));
}

TEST(Dispatch, SphereTreesAreThereOnceTheyAreDeepEnoughForThePair)
{
    const Settings settings{.bounding_volume = BoundingVolume::sphere};
    RefinedModels models(settings);
    ModelStore& store = models.store;
    Model &a = models.add(mesh), &b = models.add(mesh), &crumb = models.add(make_box_mesh({1e-3, 1e-3, 1e-3}));
    const Dispatch dispatch(settings);
    EXPECT_FALSE(dispatch.there(Level::refine, store, a, b));
    dispatch.of(Level::refine, store, a, b, 0);
    EXPECT_TRUE(dispatch.there(Level::refine, store, a, b));
    const int depth = a.spheres()->depth();
    EXPECT_FALSE(dispatch.there(Level::refine, store, a, crumb)) << "a pair with a small body has a small error";
    dispatch.of(Level::refine, store, a, crumb, 0);
    EXPECT_GT(a.spheres()->depth(), depth);
    EXPECT_TRUE(dispatch.there(Level::refine, store, a, crumb));
    EXPECT_TRUE(dispatch.there(Level::refine, store, a, b));
}

} // namespace
} // namespace oncollide::dispatch_test
