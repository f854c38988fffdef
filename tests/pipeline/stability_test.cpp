// Results do not flicker: bodies at rest, slow approaches, growing depth.
#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include <oncollide/runs/pipeline.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/motion.hpp>

#include "random_pose.hpp"

namespace oncollide {
namespace {

struct Named {
    std::string name;
    Settings settings;
};

std::vector<Named> every_combination()
{
    std::vector<Named> all;
    for (const ExactLevel exact : {ExactLevel::off, ExactLevel::predicates, ExactLevel::fcl})
        for (const BoundingVolume spheres : {BoundingVolume::sphere, BoundingVolume::obb})
            for (const Mode mode : {Mode::surface, Mode::solid})
                for (const double clearance : {0.0, 0.05})
                    for (const bool coherence : {true, false})
                        for (const int age : {1, 60})
                            for (const bool kinds : {false, true}) {
                                if (kinds && exact != ExactLevel::predicates) continue;
                                Settings s;
                                s.depth = 5, s.exact = exact, s.bounding_volume = spheres, s.mode = mode;
                                s.clearance = clearance, s.coherence = coherence, s.age_limit = age;
                                s.contact_kinds = kinds;
                                all.push_back({std::string(name_of(exact)) + ", " + std::string(name_of(spheres)) +
                                                   ", " + std::string(name_of(mode)) + ", clearance " +
                                                   std::to_string(clearance) + ", coherence " +
                                                   std::to_string(coherence) + ", age " + std::to_string(age) +
                                                   ", kinds " + std::to_string(kinds),
                                               s});
                            }
    return all;
}

/// Bodies far apart, near, touching face on face, crossing and inside each other.
Scene crowd()
{
    Scene scene;
    const GeometryId geometries[] = {
        scene.add("ball", make_sphere_mesh(0.5, 200)), scene.add("box", make_box_mesh({0.25, 0.25, 0.25})),
        scene.add("knot", make_torus_knot_mesh(2, 3, 0.5, 0.2, 0.08, 300)), scene.add("shape", Capsule{0.1, 0.3})};
    for (std::uint64_t i = 0; i < 24; ++i)
        scene.add_body({.name = std::to_string(i), .geometry = geometries[i % 4], .pose = random_pose(i, 0.9)});
    for (const double x : {3.0, 3.5, 4.0}) {
        BodyInit body{.name = std::to_string(x), .geometry = geometries[1]};
        body.pose.translation().x() = x;
        scene.add_body(body);
    }
    for (const double scale : {1.0, 0.1}) { // one inside the other
        const std::string name = "shell " + std::to_string(scale);
        BodyInit body{.name = name, .geometry = scene.add(name, make_sphere_mesh(scale, 200))};
        body.pose.translation().z() = 9;
        scene.add_body(body);
    }
    return scene;
}

using Answers = std::vector<std::tuple<std::uint32_t, std::uint32_t, Verdict, ContactKind, StageId, double>>;

Answers step(Pipeline& pipeline, const Scene& scene)
{
    Answers answers;
    for (const PairResult& p : pipeline.step(scene).pairs)
        answers.emplace_back(index(p.a), index(p.b), p.verdict, p.kind, p.stage, p.bound);
    return answers;
}

/// A separate pair's bound may come from an earlier frame.
Answers without_gaps(Answers answers)
{
    for (auto& [a, b, verdict, kind, stage, bound] : answers)
        if (verdict == Verdict::separate) bound = 0;
    return answers;
}

TEST(Stability, BodiesAtRestGetTheSameAnswerInEveryFrame)
{
    std::size_t pairs = 0;
    for (const auto& [name, settings] : every_combination()) {
        Scene scene = crowd();
        Pipeline pipeline(scene, settings);
        for (int frame = 0; frame < 3; ++frame) { // come to rest with hints and trees from other poses
            for (std::uint32_t i = 0; i < 24; ++i)
                scene.set_position(SceneBodyId{i},
                                   scene.poses.position(i) + 0.05 * random_pose(i + 100, 1).translation());
            step(pipeline, scene);
        }
        const Answers first = step(pipeline, scene);
        pairs += first.size();
        for (int frame = 0; frame < 6; ++frame) ASSERT_EQ(step(pipeline, scene), first) << name << ", frame " << frame;
        Pipeline fresh(scene, settings);
        ASSERT_EQ(without_gaps(step(fresh, scene)), without_gaps(first)) << name << ": whatever came before";
    }
    EXPECT_GT(pairs, 10'000u);
}

int rank(Verdict verdict)
{
    return verdict == Verdict::separate ? 0 : verdict == Verdict::within ? 1 : verdict == Verdict::colliding ? 2 : -1;
}

struct Approach {
    std::string name;
    Mesh a, b;
    Eigen::Vector3d way;
    double from, to;
};

std::vector<Approach> approaches()
{
    const Mesh ball = make_sphere_mesh(1, 500), box = make_box_mesh({1, 1, 1}),
               knot = make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 600);
    return {{"balls", ball, ball, {1, 0, 0}, 3.5, 1.6},
            {"balls, askew", ball, ball, {0.6, 0.3, 0.2}, 3.5, 1.6},
            {"boxes, face on face", box, box, {1, 0, 0}, 4, 1.5},
            {"a ball and a box's corner", box, ball, {1, 1.1, 0.9}, 5, 2},
            {"a ball and a knot", knot, ball, {0, 0, 1}, 4, 0.7}};
}

/// Frames of an approach and the way back: the verdicts must rise and fall once.
void expect_one_rise(const Approach& approach, const Settings& settings, int highest)
{
    constexpr int steps = 150;
    Scene scene;
    scene.add_body({.name = "a", .geometry = scene.add("a", approach.a)});
    scene.add_body({.name = "b", .geometry = scene.add("b", approach.b), .motion = Drift{}});
    scene.set_pose(SceneBodyId{0}, random_pose(3, 1));
    Pipeline pipeline(scene, settings);
    int last = 0, most = 0;
    std::vector<int> there;
    for (int k = 0; k <= 2 * steps; ++k) {
        const double part = 1 - std::abs(k - steps) / double(steps);
        Eigen::Isometry3d pose = scene.poses[0];
        pose.translate(std::lerp(approach.from, approach.to, part) * approach.way.normalized());
        scene.set_pose(SceneBodyId{1}, pose);
        const FrameView frame = pipeline.step(scene);
        const int now = frame.pairs.empty() ? 0 : rank(frame.pairs[0].verdict);
        ASSERT_GE(now, 0) << "undecided in frame " << k;
        if (k <= steps) {
            EXPECT_GE(now, last) << "frame " << k;
            there.push_back(now);
        } else {
            EXPECT_EQ(now, there[std::size_t(2 * steps - k)])
                << "frame " << k << ": the way back must give the same verdicts";
        }
        most = std::max(most, now), last = now;
    }
    EXPECT_EQ(there.front(), 0);
    EXPECT_EQ(most, highest);
}

TEST(Stability, ASlowApproachRisesFromSeparateToCollidingAndFallsOnce)
{
    for (const Approach& approach : approaches())
        for (int depth = 1; depth <= 8; ++depth)
            for (const BoundingVolume spheres : {BoundingVolume::sphere, BoundingVolume::obb})
                for (const ExactLevel exact : {ExactLevel::off, ExactLevel::predicates})
                    for (const double clearance : {0.0, 0.2}) {
                        SCOPED_TRACE(approach.name + ", depth " + std::to_string(depth) + ", " +
                                     std::string(name_of(spheres)) + ", " + std::string(name_of(exact)) +
                                     ", clearance " + std::to_string(clearance));
                        Settings settings;
                        settings.depth = depth, settings.bounding_volume = spheres, settings.exact = exact;
                        settings.clearance = clearance;
                        expect_one_rise(approach, settings, exact == ExactLevel::off ? 1 : 2);
                        if (::testing::Test::HasFailure()) return;
                    }
}

TEST(Stability, TheBoundNeverGrowsWithTheDepth)
{
    const Mesh ball = make_sphere_mesh(1, 500), knot = make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 600);
    int within = 0, parted = 0;
    for (const BoundingVolume spheres : {BoundingVolume::sphere, BoundingVolume::obb})
        for (const double clearance : {0.0, 0.1})
            for (std::uint64_t seed = 0; seed < 60; ++seed) {
                Scene scene;
                scene.add_body({.name = "a", .geometry = scene.add("a", ball)});
                scene.add_body({.name = "b", .geometry = scene.add("b", knot), .pose = random_pose(seed, 1.6)});
                PairResult last{{Verdict::within, ContactKind::unknown, 1e300}, StageId::refine, {}, {}};
                for (int depth = 1; depth <= 9; ++depth) {
                    Settings settings;
                    settings.depth = depth, settings.bounding_volume = spheres, settings.clearance = clearance;
                    Pipeline pipeline(scene, settings);
                    const FrameView frame = pipeline.step(scene);
                    if (frame.pairs.empty()) break;
                    const PairResult now = frame.pairs[0];
                    if (last.verdict == Verdict::separate) {
                        EXPECT_EQ(now.verdict, Verdict::separate) << "seed " << seed << ", depth " << depth;
                    } else if (now.verdict == Verdict::within) {
                        ++within;
                        EXPECT_LE(now.bound, last.bound) << "seed " << seed << ", depth " << depth;
                    } else
                        ++parted;
                    last = now;
                }
            }
    EXPECT_GT(within, 500);
    EXPECT_GT(parted, 20);
}

} // namespace
} // namespace oncollide
