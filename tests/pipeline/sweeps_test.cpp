// Moving models and bodies in a World: sweeps, casts of models, and frames with motions.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>

#include "random_pose.hpp"

namespace oncollide {
namespace sweeps_test {
namespace {

using Eigen::Isometry3d, Eigen::Vector3d;

Isometry3d at(double x, double y, double z)
{
    return Isometry3d(Eigen::Translation3d(x, y, z));
}

TEST(WorldSweep, OneAndManyAgree)
{
    World world({.threads = 2});
    const ModelId box = world.models().add(make_box_mesh({1, 1, 1})), ball = world.models().add(Shape(Sphere{0.5}));
    std::vector<PairOf<MovingModel>> pairs;
    for (std::uint64_t seed = 0; seed < 40; ++seed)
        pairs.push_back({{box, {random_pose(4 * seed, 1), random_pose(4 * seed + 1, 1)}},
                         {ball, {random_pose(4 * seed + 2, 4), random_pose(4 * seed + 3, 4), MotionPath::screw}}});
    std::vector<SweepResult> found(pairs.size());
    world.pairs().sweep(pairs, {}, found);
    std::size_t contacts = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        const SweepResult one = world.pairs().sweep(pairs[i].a, pairs[i].b);
        EXPECT_EQ(one.verdict, found[i].verdict);
        EXPECT_EQ(one.clear_until, found[i].clear_until);
        EXPECT_EQ(one.contact_by, found[i].contact_by);
        contacts += one.verdict == Verdict::colliding;
    }
    EXPECT_GT(contacts, 5u);
    EXPECT_LT(contacts, 35u);
}

/// A half-space moves fast where the other body is, also while its origin rests.
TEST(WorldSweep, TheGapOfAHalfSpaceThatRotatesIsABound)
{
    World world;
    const ModelId floor = world.models().add(Shape(HalfSpace{})), ball = world.models().add(Shape(Sphere{0.5}));
    Isometry3d tilted = Isometry3d::Identity();
    tilted.linear() = Eigen::AngleAxisd(0.6, Vector3d(0, -1, 0)).toRotationMatrix();
    for (const double x : {3.0, 100.0, 1e4}) {
        const RigidMotion turn(Isometry3d::Identity(), tilted), rest(at(x, 0, 0.3 * x));
        for (const bool swap : {false, true}) {
            const MovingModel plane{floor, turn}, body{ball, rest};
            const SweepResult found = swap ? world.pairs().sweep(body, plane) : world.pairs().sweep(plane, body);
            ASSERT_EQ(found.verdict, Verdict::colliding) << x;
            const Distance left = world.pairs().distance(PlacedModel{floor, turn.pose(found.clear_until)},
                                                         PlacedModel{ball, at(x, 0, 0.3 * x)});
            EXPECT_LE(left.lower, found.gap) << x << " " << swap;
            EXPECT_LE(found.gap, 1e-4 * (1 + 1e-3)) << x;
        }
    }
}

TEST(WorldSweep, ACastOfAModelFindsTheFirstBody)
{
    World world;
    const ModelId box = world.models().add(make_box_mesh({1, 1, 1})), ball = world.models().add(Shape(Sphere{0.5}));
    std::vector<BodyId> boxes;
    for (const double x : {12.0, 4.0, 8.0}) boxes.push_back(world.bodies().add({.model = box, .pose = at(x, 0, 0)}));
    const MovingModel way{ball, {at(0, 0, 0), at(20, 0, 0)}};
    const SweepHit first = world.space().cast(way);
    EXPECT_EQ(first.body, boxes[1]);
    EXPECT_LE(first.clear_until, 2.5 / 20);
    EXPECT_GE(first.contact_by, 2.5 / 20);
    EXPECT_LE(first.contact_by - first.clear_until, 1e-4);
    const std::vector<SweepHit> all = world.space().cast_all(way);
    ASSERT_EQ(all.size(), 3u);
    EXPECT_EQ(all[0].body, boxes[1]);
    EXPECT_EQ(all[1].body, boxes[2]);
    EXPECT_EQ(all[2].body, boxes[0]);
    EXPECT_NEAR(all[2].contact_by, 10.5 / 20, 1e-4);
    const SweepHit beside = world.space().cast({ball, {at(0, 1.6, 0), at(20, 1.6, 0)}});
    EXPECT_FALSE(beside.body);
    EXPECT_EQ(beside.verdict, Verdict::separate);
    EXPECT_EQ(beside.clear_until, 1);
    EXPECT_FALSE(world.space().cast(way, {.mask = 2}).body);
}

TEST(WorldSweep, RefusesToleranceZeroAndNamesTheLeast)
{
    World world;
    const ModelId ball = world.models().add(Shape(Sphere{0.5}));
    const MovingModel way{ball, {at(0, 0, 0), at(20, 0, 0)}};
    const auto message = [&](const SweepOptions& options) -> std::string {
        try {
            world.pairs().sweep(way, way, options);
        } catch (const Error& error) {
            EXPECT_EQ(error.kind(), ErrorKind::usage);
            return error.what();
        }
        return "";
    };
    EXPECT_EQ(message({.time_tolerance = 0}), "sweep: time_tolerance 0: must be at least 1e-12");
    EXPECT_EQ(message({.gap_tolerance = std::nan("")}), "sweep: gap_tolerance nan: must be at least 1e-12");
    EXPECT_EQ(message({.most_steps = 0}), "sweep: most_steps 0: must be at least 1");
}

/// A wall, and small fast bodies that fly through it.
struct Range {
    explicit Range(const Settings& settings = {}) : world(settings)
    {
        const ModelId plate = world.models().add(make_box_mesh({0.001, 5, 5})),
                      bullet = world.models().add(make_sphere_mesh(0.005, 32));
        wall = world.bodies().add({.model = plate, .is_static = true});
        for (int i = 0; i < 20; ++i)
            bullets.push_back(world.bodies().add({.model = bullet, .pose = at(-3, 0.6 * i - 6, 0.1)}));
    }
    World world;
    BodyId wall;
    std::vector<BodyId> bullets;
};

TEST(WorldMotion, FastBodiesDoNotPassAWallUnseen)
{
    Range range;
    range.world.step();
    for (std::size_t i = 0; i < range.bullets.size(); ++i)
        range.world.bodies().set_motion(range.bullets[i], at(997, 0.6 * double(i) - 6, 0.1));
    const FrameView frame = range.world.step();
    std::size_t hits = 0;
    for (const PairSweep& sweep : frame.sweeps) {
        const PairResult& pair = frame.pairs[sweep.pair];
        EXPECT_EQ(pair.a, range.wall);
        EXPECT_EQ(pair.verdict, sweep.verdict);
        if (sweep.verdict != Verdict::colliding) continue;
        ++hits;
        EXPECT_NEAR(sweep.contact_by, (3 - 0.006) / 1000, 1e-6);
        EXPECT_LE(sweep.clear_until, (3 - 0.006 + 1e-4) / 1000);
    }
    EXPECT_EQ(hits, 17u); // the others fly beside it
    EXPECT_EQ(frame.began.size(), 17u);
    // The bodies are at the ends of their ways, and the next frame is discrete.
    EXPECT_EQ(range.world.bodies().pose(range.bullets[3]).translation().x(), 997);
    const FrameView next = range.world.step();
    EXPECT_TRUE(next.sweeps.empty());
    EXPECT_TRUE(next.pairs.empty());
    EXPECT_EQ(next.ended.size(), 17u);
    EXPECT_EQ(range.world.step().pairs.size(), 0u);
}

TEST(WorldMotion, ResultsDoNotDependOnThreadsOrCoherence)
{
    const auto play = [](const Settings& settings) {
        World world(settings);
        const ModelId ring = world.models().add(make_torus_mesh(1, 0.3, 500)),
                      ball = world.models().add(Shape(Sphere{0.5}));
        std::vector<BodyId> bodies;
        for (std::uint64_t i = 0; i < 40; ++i)
            bodies.push_back(world.bodies().add({.model = i % 2 ? ring : ball, .pose = random_pose(i, 6)}));
        for (std::uint64_t frame = 0; frame < 6; ++frame) {
            for (std::uint64_t i = 0; i < 40; ++i)
                if ((i + frame) % 3) world.bodies().set_motion(bodies[i], random_pose(100 * frame + i, 6));
            world.step();
        }
        return world.hash();
    };
    const std::uint64_t hash = play({});
    EXPECT_EQ(play({.threads = 3}), hash);
    EXPECT_EQ(play({.coherence = false}), hash);
    EXPECT_EQ(play({.broad_phase = BroadPhaseKind::brute_force}), hash);
}

/// Pairs that touch, part, or keep a gap for frames.
TEST(WorldMotion, SlowBodiesGiveTheSameResultsWithoutCoherence)
{
    const auto play = [](bool coherence) {
        World world({.coherence = coherence});
        const ModelId knot = world.models().add(make_torus_knot_mesh(2, 3, 0.6, 0.25, 0.1, 400)),
                      ball = world.models().add(Shape(Sphere{0.4}));
        constexpr std::uint64_t count = 40;
        for (std::uint64_t i = 0; i < count; ++i)
            world.bodies().add({.model = i % 3 ? knot : ball, .pose = random_pose(i, 2.5)});
        std::vector<std::uint64_t> hashes;
        std::size_t contacts = 0;
        for (std::uint64_t frame = 0; frame < 60; ++frame) {
            for (std::uint32_t i = 0; i < count; ++i) {
                const BodyId body = world.bodies().at(i);
                const Vector3d step = 0.1 * (random_pose(1000 * frame + i, 1).translation());
                Isometry3d to(Eigen::AngleAxisd(step.norm(), step.normalized()) * world.bodies().pose(body).linear());
                to.translation() = world.bodies().pose(body).translation() + 0.5 * step;
                if ((i + frame) % 4)
                    world.bodies().set_motion(body, to, frame % 2 ? MotionPath::screw : MotionPath::linear);
            }
            const FrameView view = world.step();
            for (const PairSweep& sweep : view.sweeps)
                contacts += sweep.verdict == Verdict::colliding && sweep.contact_by > 0;
            hashes.push_back(view.hash);
        }
        EXPECT_GT(contacts, 20u);
        return hashes;
    };
    EXPECT_EQ(play(true), play(false));
}

/// The pair keeps a gap of an earlier frame, and the body ends where it began.
TEST(WorldMotion, AContactOnAWayThatComesBackIsFound)
{
    World world;
    Isometry3d slanted(Eigen::AngleAxisd(M_PI / 4, Vector3d::UnitZ()));
    const Vector3d normal = slanted.linear().col(0);
    world.bodies().add({.model = world.models().add(make_box_mesh({0.01, 5, 5})), .pose = slanted, .is_static = true});
    const auto beside = [&](double distance) { return Isometry3d(Eigen::Translation3d(distance * normal)); };
    const BodyId ball =
        world.bodies().add({.model = world.models().add(make_sphere_mesh(0.5, 200)), .pose = beside(2)});
    const FrameView apart = world.step();
    ASSERT_EQ(apart.pairs.size(), 1u);
    ASSERT_GT(apart.pairs[0].bound, 0.1) << "the gap";
    for (const double nearest : {0.6, 0.4}) {
        const RigidMotion::Key way[] = {{0, beside(2)}, {0.5, beside(nearest)}, {1, beside(2 - 1e-3)}};
        world.bodies().set_motion(ball, RigidMotion(way));
        const FrameView frame = world.step();
        ASSERT_EQ(frame.sweeps.size(), 1u);
        EXPECT_EQ(frame.sweeps[0].verdict, nearest < 0.5 ? Verdict::colliding : Verdict::separate);
        world.bodies().set_pose(ball, beside(2));
        world.step();
    }
}

TEST(WorldMotion, FindsAllContactsOfSampledPoses)
{
    World world, sampled;
    const auto fill = [](World& w) {
        const ModelId ring = w.models().add(make_torus_mesh(1, 0.3, 200)), ball = w.models().add(Shape(Sphere{0.5}));
        for (std::uint64_t i = 0; i < 24; ++i)
            w.bodies().add({.model = i % 2 ? ring : ball, .pose = random_pose(i, 4)});
    };
    fill(world), fill(sampled);
    std::vector<RigidMotion> ways;
    for (std::uint32_t i = 0; i < 24; ++i) {
        ways.emplace_back(world.bodies().pose(world.bodies().at(i)), random_pose(500 + i, 4), MotionPath::screw);
        world.bodies().set_motion(world.bodies().at(i), ways.back());
    }
    const FrameView frame = world.step();
    const auto sweep_of = [&](const PairOfBodies& pair) -> const PairSweep* {
        for (const PairSweep& sweep : frame.sweeps)
            if (frame.pairs[sweep.pair].a.slot == pair.a.slot && frame.pairs[sweep.pair].b.slot == pair.b.slot)
                return &sweep;
        return nullptr;
    };
    std::size_t checked = 0;
    for (int k = 0; k <= 200; ++k) {
        const double time = k / 200.0;
        for (std::uint32_t i = 0; i < 24; ++i) sampled.bodies().set_pose(sampled.bodies().at(i), ways[i].pose(time));
        for (const PairResult& pair : sampled.step().pairs) {
            if (pair.verdict != Verdict::colliding) continue;
            const PairSweep* const sweep = sweep_of({pair.a, pair.b});
            ASSERT_TRUE(sweep) << "the broad phase found the pair";
            EXPECT_NE(sweep->verdict, Verdict::separate);
            EXPECT_LE(sweep->clear_until, time);
            ++checked;
        }
    }
    EXPECT_GT(checked, 100u);
}

TEST(WorldMotion, WhatHasNoMotionIsDecidedAsBefore)
{
    World world, still;
    for (World* const w : {&world, &still}) {
        const ModelId ball = w->models().add(Shape(Sphere{0.5}));
        for (const double x : {0.0, 0.9, 5.0}) w->bodies().add({.model = ball, .pose = at(x, 0, 0)});
        w->step();
    }
    world.bodies().set_motion(world.bodies().at(2), at(5, 0, 0)); // rests
    EXPECT_EQ(world.step().hash, still.step().hash);
    world.bodies().set_motion(world.bodies().at(2), at(7, 0, 0));
    const FrameView frame = world.step();
    EXPECT_EQ(frame.pairs.size(), 1u);
    EXPECT_TRUE(frame.sweeps.empty());
    world.bodies().set_motion(world.bodies().at(2), at(1.5, 0, 0));
    world.bodies().set_pose(world.bodies().at(2), at(9, 0, 0)); // replaces the motion
    EXPECT_TRUE(world.step().sweeps.empty());
}

} // namespace
} // namespace sweeps_test
} // namespace oncollide
