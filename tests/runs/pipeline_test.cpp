#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include <oncollide/base/error.hpp>
#include <oncollide/runs/pipeline.hpp>
#include <oncollide/samples/catalogue.hpp>
#include <oncollide/samples/generators.hpp>

#include "count_allocations.hpp"

namespace oncollide::pipeline_test {
namespace {

Scene many(int bodies)
{
    return make_scene("many", {.bodies = bodies, .frames = {}, .seed = 7, .data = {}});
}

std::uint64_t run(Scene scene, const Settings& settings, int frames)
{
    Pipeline pipeline(scene, settings);
    Mover mover;
    for (int frame = 0; frame < frames; ++frame) {
        mover.move(scene, frame);
        pipeline.step(scene);
    }
    return pipeline.hash();
}

/// Two knots on the x axis, `apart` metres between their centres.
Scene two_knots(double apart)
{
    Scene scene;
    const GeometryId knot = scene.add("knot", make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 1500));
    scene.add_body({.name = "a", .geometry = knot, .motion = Drift{}});
    scene.add_body({.name = "b", .geometry = knot, .motion = Drift{}});
    scene.set_position(SceneBodyId{1}, {apart, 0, 0});
    return scene;
}

TEST(Pipeline, PlaysInAWorldThatItIsGivenIfThatIsNew)
{
    const Scene scene = two_knots(2);
    World world;
    world.set_pair_filter([](std::span<const CandidatePair>, std::span<PairChoice> choices) {
        std::ranges::fill(choices, PairChoice::drop);
    });
    Pipeline pipeline(scene, std::move(world));
    EXPECT_EQ(Pipeline(scene).step(scene).pairs.size(), 1u);
    EXPECT_EQ(pipeline.step(scene).pairs.size(), 0u) << "the filter of the World";
    World used;
    used.models().add(Sphere{1});
    EXPECT_THROW(Pipeline(scene, std::move(used)), Error);
}

TEST(Pipeline, GivesTheSameHashForAnyThreadCountBroadPhaseAndCoherence)
{
    const Scene scene = many(600);
    for (const ExactLevel exact : {ExactLevel::off, ExactLevel::fcl}) {
        const auto settings = [&](auto change) {
            Settings s{.depth = 5, .exact = exact};
            change(s);
            return s;
        };
        const std::uint64_t expected = run(scene, settings([](Settings&) {}), 4);
        EXPECT_EQ(run(scene, settings([](Settings& s) { s.threads = 2; }), 4), expected);
        EXPECT_EQ(run(scene, settings([](Settings& s) { s.threads = 4; }), 4), expected);
        EXPECT_EQ(run(scene, settings([](Settings& s) { s.broad_phase = BroadPhaseKind::octree; }), 4), expected);
        EXPECT_EQ(run(scene, settings([](Settings& s) { s.broad_phase = BroadPhaseKind::brute_force; }), 4), expected);
        EXPECT_EQ(run(scene, settings([](Settings& s) { s.coherence = false; }), 4), expected);
        EXPECT_EQ(run(scene, settings([](Settings& s) { s.age_limit = 1; }), 4), expected);
        const std::uint64_t shallow = run(scene, settings([](Settings& s) { s.depth = 4; }), 4);
        EXPECT_EQ(shallow == expected, exact == ExactLevel::fcl)
            << "the hash includes the bounds; exact results have none";
    }
}

TEST(Pipeline, AllocatesNothingInAWarmFrame)
{
    Scene scene = many(300);
    for (const ExactLevel exact : {ExactLevel::off, ExactLevel::predicates}) {
        Pipeline pipeline(scene, {.depth = 5, .exact = exact, .age_limit = 100000});
        Mover mover;
        constexpr int last = 6; // the last repetition of the same frames needs no new memory
        for (int lap = 0; lap <= last; ++lap)
            for (int frame = 0; frame < 12; ++frame) {
                mover.move(scene, frame);
                const std::size_t before = allocations;
                pipeline.step(scene);
                if (lap == last) {
                    EXPECT_EQ(allocations - before, 0u) << "frame " << frame;
                }
            }
    }
}

TEST(Pipeline, GrowsTreesWhileBodiesTouchAndDropsThemAfter)
{
    Scene scene = two_knots(5);
    Pipeline pipeline(scene, {.depth = 6, .age_limit = 10});
    EXPECT_EQ(pipeline.step(scene).trees.nodes, 0u) << "no candidate, no tree";
    scene.set_position(SceneBodyId{1}, {0.5, 0, 0});
    const FrameView touching = pipeline.step(scene);
    EXPECT_GT(touching.trees.nodes, 20u);
    EXPECT_GT(touching.trees.rounds, 0u);
    ASSERT_EQ(touching.pairs.size(), 1u);
    EXPECT_EQ(touching.pairs[0].verdict, Verdict::within);
    scene.set_position(SceneBodyId{1}, {5, 0, 0});
    TreeStats last;
    for (int frame = 0; frame < 15; ++frame) last = pipeline.step(scene).trees;
    EXPECT_EQ(last.nodes, 1u) << "one mesh, one root";
    EXPECT_LT(last.bytes, 4096u);
}

TEST(Pipeline, MeetsTheErrorAskedFor)
{
    Scene scene = two_knots(0.5);
    for (const double error : {0.5, 0.1, 0.02}) {
        Pipeline pipeline(scene, {.max_error = error});
        const FrameView view = pipeline.step(scene);
        ASSERT_EQ(view.pairs.size(), 1u);
        EXPECT_EQ(view.pairs[0].verdict, Verdict::within);
        EXPECT_LE(view.pairs[0].bound, error);
        EXPECT_GT(view.pairs[0].bound, error / 2.5) << "no deeper than needed";
    }
}

TEST(Pipeline, SaysUndecidedWhenABudgetStopsIt)
{
    Scene scene = two_knots(0.5);
    for (const Settings& settings :
         {Settings{.depth = 8, .node_budget = 40}, Settings{.depth = 8, .memory_budget = 1}}) {
        Pipeline pipeline(scene, settings);
        for (int frame = 0; frame < 3; ++frame) {
            const FrameView view = pipeline.step(scene);
            ASSERT_EQ(view.pairs.size(), 1u);
            EXPECT_EQ(view.pairs[0].verdict, Verdict::undecided);
            EXPECT_GT(view.trees.refused, 0u);
            EXPECT_GT(view.pairs[0].bound, 0);
            EXPECT_LT(view.pairs[0].bound, 20);
            if (settings.node_budget) {
                EXPECT_LE(view.trees.nodes, settings.node_budget);
            }
        }
    }
}

TEST(Pipeline, KeepsEveryPairWhenEveryStageIsSkipped)
{
    Scene scene = two_knots(50);
    Pipeline pipeline(
        scene, {.skip = {StageId::bounds, StageId::delimitation, StageId::broad, StageId::refine, StageId::exact}});
    const FrameView view = pipeline.step(scene);
    ASSERT_EQ(view.pairs.size(), 1u);
    EXPECT_EQ(view.pairs[0].verdict, Verdict::undecided);
    EXPECT_GE(view.pairs[0].bound, 47) << "the bound is certified with any stages skipped";
    for (const StageStats& stage : view.stages) EXPECT_TRUE(stage.skipped);
}

TEST(Pipeline, FindsABodyInsideAnotherInSolidModeOnly)
{
    Scene scene;
    const GeometryId ball = scene.add("ball", make_sphere_mesh(2, 1000)),
                     box = scene.add("box", make_box_mesh({0.2, 0.2, 0.2}));
    scene.add_body({.name = "ball", .geometry = ball, .motion = Drift{}});
    scene.add_body({.name = "box", .geometry = box, .motion = Drift{}});
    for (const ExactLevel exact : {ExactLevel::off, ExactLevel::fcl}) {
        Pipeline surface(scene, {.exact = exact}), solid(scene, {.exact = exact, .mode = Mode::solid});
        EXPECT_EQ(surface.step(scene).pairs[0].verdict, Verdict::separate);
        EXPECT_EQ(solid.step(scene).pairs[0].verdict, Verdict::colliding);
    }
}

TEST(Pipeline, AClearanceWidensEveryStage)
{
    Scene scene;
    const GeometryId box = scene.add("box", Shape{Box{{1, 1, 1}}});
    scene.add_body({.name = "a", .geometry = box, .motion = Drift{}});
    scene.add_body({.name = "b", .geometry = box, .motion = Drift{}});
    scene.set_position(SceneBodyId{1}, {2.5, 0, 0});
    Pipeline without(scene, {.depth = 8}), with(scene, {.depth = 8, .clearance = 0.6}),
        exact(scene, {.depth = 8, .clearance = 0.6, .exact = ExactLevel::fcl});
    EXPECT_TRUE(without.step(scene).pairs.empty());
    ASSERT_EQ(with.step(scene).pairs.size(), 1u);
    EXPECT_EQ(with.step(scene).pairs[0].verdict, Verdict::within);
    const PairResult result = exact.step(scene).pairs[0];
    EXPECT_EQ(result.verdict, Verdict::within);
    EXPECT_NEAR(result.bound, 0.5, 1e-5);
}

TEST(Pipeline, AnswersForNoBodyAndForOne)
{
    Scene scene;
    Pipeline empty(scene);
    EXPECT_TRUE(empty.step(scene).pairs.empty());
    scene.add_body({.name = "a", .geometry = scene.add("box", make_box_mesh({1, 1, 1})), .motion = Drift{}});
    Pipeline one(scene, {.exact = ExactLevel::fcl, .skip = {StageId::broad, StageId::refine}});
    EXPECT_TRUE(one.step(scene).pairs.empty());
    EXPECT_TRUE(empty.step(scene).pairs.empty()) << "the new body is included";
    EXPECT_EQ(empty.world().bodies().size(), 1u);
}

TEST(Pipeline, RefusesPosesThatAreNotRigidAndNamesTheBody)
{
    const auto message = [](Eigen::Isometry3d pose) {
        Scene scene = two_knots(3);
        Pipeline pipeline(scene);
        scene.set_pose(SceneBodyId{1}, pose);
        try {
            pipeline.step(scene);
        } catch (const Error& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    EXPECT_EQ(message(pose), "");
    pose.translation().x() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_NE(message(pose).find("'b'"), std::string::npos);
    pose.translation().x() = 1e300;
    EXPECT_NE(message(pose), "");
    pose = Eigen::Isometry3d::Identity();
    pose.linear() *= 2;
    EXPECT_NE(message(pose), "");
    pose.linear() = -Eigen::Matrix3d::Identity();
    EXPECT_NE(message(pose), "");
}

TEST(Pipeline, CountsTheOcclusionQueriesOfThePaper)
{
    const Scene scene = two_knots(0.5);
    Pipeline pipeline(scene, {.depth = 4, .backend = BackendKind::gl_query, .viewport = 32});
    const FrameView frame = pipeline.step(scene);
    EXPECT_NE(pipeline.inspect().renderer, "");
    EXPECT_NE(pipeline.inspect().backend_note.find("not certified"), std::string::npos);
    EXPECT_GE(frame.trees.queries, 8 * frame.trees.rows);
    EXPECT_LE(frame.trees.queries, 24 * frame.trees.rows);
    ASSERT_EQ(frame.pairs.size(), 1u);
    EXPECT_EQ(frame.pairs[0].verdict, Verdict::within);
}

TEST(Pipeline, RefusesSettingsOutOfRange)
{
    const Scene scene = two_knots(3);
    for (const Settings& settings :
         {Settings{.depth = 0}, Settings{.depth = 99}, Settings{.depth = 3, .max_error = 1.0},
          Settings{.max_error = -1.0}, Settings{.clearance = std::numeric_limits<double>::quiet_NaN()},
          Settings{.gpu = -2}, Settings{.viewport = 0}, Settings{.threads = -1}})
        EXPECT_THROW(Pipeline(scene, settings), Error);
}

TEST(Pipeline, FollowsEveryKindOfChangeAsIfMadeAnew)
{
    Scene scene = two_knots(0.9);
    scene.add("ball", Shape{Sphere{0.3}});
    scene.add_body({.name = "c", .geometry = GeometryId{1}, .is_static = true});
    const Settings settings{.depth = 6};
    Pipeline pipeline(scene, settings);
    Scene copy;
    const auto expect_followed = [&](const Scene& now, const char* what) {
        EXPECT_EQ(pipeline.step(now).hash, Pipeline(now, settings).step(now).hash) << what;
    };
    expect_followed(scene, "nothing");
    scene.set_position(SceneBodyId{1}, {0.8, 0, 0});
    expect_followed(scene, "a pose");
    scene.set_geometry(SceneBodyId{0}, GeometryId{1});
    expect_followed(scene, "a geometry");
    scene.set_layers(SceneBodyId{0}, 2, 2);
    expect_followed(scene, "layers");
    scene.set_layers(SceneBodyId{0}, 1, 1), scene.set_group(SceneBodyId{0}, 3), scene.set_group(SceneBodyId{1}, 3);
    expect_followed(scene, "groups");
    scene.set_group(SceneBodyId{0}, 0), scene.set_static(SceneBodyId{1}, true);
    expect_followed(scene, "rest");
    copy = scene;
    copy.set_static(SceneBodyId{1}, false), copy.set_position(SceneBodyId{1}, {0.1, 0, 0});
    expect_followed(copy, "a copy, changed");
    expect_followed(scene, "the first one again");
    for (int k = 0; k < 5000; ++k) scene.set_position(SceneBodyId{0}, {0.001 * k, 0, 0});
    scene.set_position(SceneBodyId{0}, {0.05, 0, 0});
    expect_followed(scene, "more changes than the log holds");
    scene.add_body({.name = "d", .geometry = GeometryId{0}});
    expect_followed(scene, "a new body");
}

/// A wall at x = 0, and a ball that flies through it and back from frame 2.25 to frame 2.75.
Scene wall_and_ball()
{
    Scene scene;
    scene.add("wall", Box{{0.01, 5, 5}}), scene.add("ball", Sphere{0.1});
    scene.add_body({.name = "wall", .geometry = GeometryId{0}, .is_static = true});
    const Eigen::Quaterniond r = Eigen::Quaterniond::Identity();
    const Eigen::Vector3d from(-3, 0, 0), to(5, 0, 0);
    scene.add_body({.name = "ball",
                    .geometry = GeometryId{1},
                    .motion = Keyed{{{0, from, r}, {2.25, from, r}, {2.5, to, r}, {2.75, from, r}}}});
    return scene;
}
constexpr double of_contact = 2.25 + 0.25 * (3 - 0.11) / 8;

TEST(Pipeline, BodiesOnTheirWaysPassTheKeysBetweenTwoFrames)
{
    for (const double pace : {0.01, 0.3, 1.0, 2.6, 5.0, 100.0}) {
        Scene scene = wall_and_ball();
        scene.pace = pace;
        Mover mover;
        mover.move(scene, 0);
        Pipeline pipeline(scene);
        pipeline.set_continuous(true);
        double first = 1e9;
        for (int frame = 0; frame * pace < 3 + pace && first == 1e9; ++frame) {
            mover.move(scene, frame);
            for (const PairSweep& sweep : pipeline.step(scene).sweeps)
                if (sweep.verdict == Verdict::colliding) {
                    first = (frame - 1 + sweep.contact_by) * pace;
                    EXPECT_LE((frame - 1 + sweep.clear_until) * pace, of_contact);
                }
        }
        EXPECT_GE(first, of_contact) << pace;
        EXPECT_LE(first, of_contact + 1e-4 * pace + 1e-12) << pace;
    }
}

TEST(Pipeline, NoWayIsLostWhereABodyChangesTwiceOrFramesAreLeftOut)
{
    const auto contacts = [](const auto& play) {
        Scene scene = wall_and_ball();
        Mover mover;
        mover.move(scene, 0);
        Pipeline pipeline(scene);
        pipeline.set_continuous(true);
        pipeline.step(scene);
        play(scene, mover);
        const FrameView frame = pipeline.step(scene);
        return std::ranges::count(frame.sweeps, Verdict::colliding, &PairSweep::verdict);
    };
    const SceneBodyId ball{1};
    EXPECT_EQ(contacts([&](Scene& scene, Mover& mover) { mover.move(scene, 1), mover.move(scene, 4); }), 1);
    EXPECT_EQ(contacts([&](Scene& scene, Mover& mover) {
                  mover.move(scene, 3);
                  scene.set_layers(ball, 1, 1);
              }),
              1);
    EXPECT_EQ(contacts([&](Scene& scene, Mover&) {
                  scene.set_position(ball, {3, 0, 0});
                  scene.set_layers(ball, 1, 1);
                  scene.set_position(ball, {4, 0, 0});
              }),
              1);
    EXPECT_EQ(contacts([&](Scene& scene, Mover& mover) { mover.move(scene, 2); }), 0);
}

} // namespace
} // namespace oncollide::pipeline_test
