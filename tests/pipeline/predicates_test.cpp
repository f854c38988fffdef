// The exact level `predicates`, compared with brute force over all pairs of triangles.
#include <cmath>
#include <tuple>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <oncollide/base/error.hpp>
#include <oncollide/narrowphase/walks/traversal.hpp>
#include <oncollide/pipeline/results.hpp>
#include <oncollide/runs/pipeline.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/motion.hpp>

#include "random_pose.hpp"

namespace oncollide::predicates_test {
namespace {

std::vector<TrianglePair> brute_force(const Mesh& a, const Mesh& b, const Eigen::Isometry3d& pose_a,
                                      const Eigen::Isometry3d& pose_b)
{
    const RelativePose b_to_a(pose_a, pose_b);
    const auto corners = [](const Mesh& mesh, std::uint32_t t, auto place) {
        TrianglePoints points;
        for (std::size_t k = 0; k < 3; ++k) points[k] = place(mesh.vertices[mesh.triangles[t][k]]);
        return points;
    };
    std::vector<TrianglePair> pairs;
    for (std::uint32_t i = 0; i < a.triangles.size(); ++i)
        for (std::uint32_t j = 0; j < b.triangles.size(); ++j)
            if (triangles_meet(corners(a, i, [](const Eigen::Vector3d& p) { return p; }), corners(b, j, b_to_a)))
                pairs.push_back({i, j});
    return pairs;
}

Scene two(const Mesh& a, const Mesh& b)
{
    Scene scene;
    scene.add_body({.name = "a", .geometry = scene.add("a", a), .motion = Drift{}});
    scene.add_body({.name = "b", .geometry = scene.add("b", b), .motion = Drift{}});
    return scene;
}

Mesh scaled(const Mesh& mesh, double scale, const Eigen::Vector3d& by)
{
    return transformed("scaled", mesh, scale, -by / scale);
}

TEST(Predicates, CountWhatTheFilterLeavesToExactArithmetic)
{
    Scene scene = two(make_box_mesh({0.5, 0.5, 0.5}), make_box_mesh({0.5, 0.5, 0.5}));
    Pipeline pipeline(scene, {.exact = ExactLevel::predicates});
    for (const auto& [gap, unsure] : {std::pair(0x1p-52, true), std::pair(1e-3, false)}) {
        scene.set_position(SceneBodyId{1}, Eigen::Vector3d(1 + gap, 0.3, 0.2));
        const TreeStats trees = pipeline.step(scene).trees;
        EXPECT_EQ(trees.unsure_pairs > 0, unsure) << gap;
        EXPECT_LE(trees.unsure_pairs, trees.triangle_pairs);
    }
}

/// Boxes that touch at a face, an edge, a corner, or a part of a face; and boxes one ulp apart.
TEST(Predicates, CallTouchingCollidingToTheLastBit)
{
    Scene scene = two(make_box_mesh({0.5, 0.5, 0.5}), make_box_mesh({0.5, 0.5, 0.5}));
    Pipeline pipeline(scene, {.exact = ExactLevel::predicates});
    const auto collide = [&](double x, double y, double z) {
        scene.set_position(SceneBodyId{1}, Eigen::Vector3d(x, y, z));
        const FrameView frame = pipeline.step(scene);
        return !frame.pairs.empty() && frame.pairs[0].verdict == Verdict::colliding;
    };
    for (const double y : {0.0, 0.05, 1.0})
        for (const double z : {0.0, 0.3, 1.0}) {
            EXPECT_TRUE(collide(1, y, z)) << y << ' ' << z;
            EXPECT_FALSE(collide(std::nextafter(1, 2), y, z)) << y << ' ' << z;
        }
    EXPECT_TRUE(collide(0, 0, 0)) << "the same mesh in the same pose";
    EXPECT_TRUE(collide(0.05, 0, 0)) << "walls overlap in their own planes";
}

TEST(Predicates, GiveOneHashForThreadsBackendsAndCoherence)
{
    const auto hash = [](Settings settings, int* colliding = nullptr) {
        settings.exact = ExactLevel::predicates;
        Scene scene;
        const GeometryId knot = scene.add("knot", make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 600));
        const GeometryId soup = scene.add("soup", make_soup_mesh(300, 0.3, 1.5, 6));
        for (std::uint32_t i = 0; i < 24; ++i) {
            scene.add_body({.name = std::to_string(i), .geometry = i % 2 ? knot : soup, .motion = Drift{}});
            scene.set_pose(SceneBodyId{std::uint32_t(i)}, random_pose(i, 3));
        }
        Pipeline pipeline(scene, settings);
        for (int frame = 0; frame < 8; ++frame) {
            for (std::uint32_t i = 0; i < scene.size(); ++i) {
                Eigen::Isometry3d pose = scene.poses[i];
                pose.rotate(Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitZ())), pose.translation().x() *= 0.95;
                scene.set_pose(SceneBodyId{i}, pose);
            }
            for (const PairResult& pair : pipeline.step(scene).pairs)
                if (colliding) *colliding += pair.verdict == Verdict::colliding;
        }
        return pipeline.hash();
    };
    int colliding = 0;
    const std::uint64_t plain = hash({}, &colliding);
    EXPECT_GT(colliding, 100);
    EXPECT_EQ(plain, hash({.threads = 3}));
    EXPECT_EQ(plain, hash({.coherence = false}));
    EXPECT_EQ(plain, hash({.bounding_volume = BoundingVolume::sphere}));
    EXPECT_EQ(plain, hash({.age_limit = 1}));
    EXPECT_EQ(plain, hash({.backend = BackendKind::gl_compute})) << "the triangles are still on the CPU";
}

TEST(Contacts, AreAllPairsOfBruteForceWithPointsOnBothTriangles)
{
    const Mesh knot = make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 300);
    World world;
    const ModelId model = world.models().add(knot);
    const BodyId a = world.bodies().add({.model = model}), b = world.bodies().add({.model = model});
    Scene scene = two(knot, knot);
    std::size_t found = 0;
    for (std::uint64_t seed = 20; seed < 26; ++seed) {
        scene.set_pose(SceneBodyId{0}, random_pose(seed, 100)),
            scene.set_pose(SceneBodyId{1}, scene.poses[0] * random_pose(seed + 50, 0.7));
        const auto expected = brute_force(knot, knot, scene.poses[0], scene.poses[1]);
        world.bodies().set_pose(a, scene.poses[0]), world.bodies().set_pose(b, scene.poses[1]);
        const std::vector<Contact> contacts = world.pairs().contacts(a, b);
        ASSERT_EQ(contacts.size(), expected.size());
        found += contacts.size();
        for (std::size_t k = 0; k < contacts.size(); ++k) {
            const Contact& c = contacts[k];
            EXPECT_EQ((TrianglePair{c.a.triangle, c.b.triangle}), expected[k]);
            EXPECT_EQ(c.kind, ContactKind::crossing);
            for (const auto& [body, triangle, normal] :
                 {std::tuple(0, c.a.triangle, c.normal_a), std::tuple(1, c.b.triangle, c.normal_b)}) {
                const Eigen::Vector3d corner =
                    scene.poses[std::size_t(body)] * knot.vertices[knot.triangles[triangle][0]];
                EXPECT_NEAR(normal.norm(), 1, 1e-12);
                for (const Eigen::Vector3d& end : c.ends) EXPECT_NEAR(normal.dot(end - corner), 0, 1e-12);
            }
        }
    }
    EXPECT_GT(found, 50u);

    World crowd({.threads = 3});
    const ModelId shape = crowd.models().add(knot);
    std::vector<PairOfBodies> pairs;
    for (std::uint32_t i = 0; i < 30; ++i) {
        crowd.bodies().add({.model = shape, .pose = random_pose(i, 1.2)});
        for (std::uint32_t j = 0; j < i; ++j) pairs.push_back({crowd.bodies().at(j), crowd.bodies().at(i)});
    }
    Lists<Contact> lists;
    crowd.pairs().contacts(pairs, lists);
    ASSERT_EQ(lists.offsets.size(), pairs.size() + 1);
    std::size_t begin = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        const auto alone = crowd.pairs().contacts(pairs[i].a, pairs[i].b);
        ASSERT_EQ(lists.offsets[i + 1] - begin, alone.size());
        for (std::size_t k = 0; k < alone.size(); ++k) {
            EXPECT_EQ(lists.items[begin + k].a.triangle, alone[k].a.triangle);
            EXPECT_EQ(lists.items[begin + k].ends, alone[k].ends);
        }
        begin = lists.offsets[i + 1];
    }
    EXPECT_GT(begin, 1000u);

    EXPECT_THROW(world.pairs().contacts(a, BodyId{7}), Error);
    scene.set_position(SceneBodyId{1}, scene.poses.position(1) + Eigen::Vector3d(50, 0, 0));
    world.bodies().set_pose(b, scene.poses[1]);
    EXPECT_TRUE(world.pairs().contacts(a, b).empty());
}

TEST(PairsOfModels, AnswerAsBruteForceForManyPosesAndSizes)
{
    const Mesh knot = make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 300);
    const std::vector<Mesh> meshes{knot, scaled(knot, 0.04, {0, 0, 0}), make_soup_mesh(120, 0.5, 1.5, 6)};
    World conservative({.exact = ExactLevel::off}), exact({.exact = ExactLevel::predicates}),
        threaded({.exact = ExactLevel::predicates, .threads = 3});
    std::vector<PairOfModels> of_world[3];
    for (int w = 0; World* const world : {&conservative, &exact, &threaded}) {
        std::vector<ModelId> models;
        for (const Mesh& mesh : meshes) models.push_back(world->models().add(mesh));
        for (std::uint32_t i = 0; i < 60; ++i) {
            const Eigen::Isometry3d at = random_pose(i, 100);
            of_world[w].push_back(
                {{models[i % 3], at}, {models[(i / 3) % 3], at * random_pose(i + 500, i % 3 == 1 ? 0.6 : 1.3)}});
        }
        ++w;
    }
    std::vector<Finding> wide(60), sharp(60), same(60);
    for (int call = 0; call < 2; ++call) {
        conservative.pairs().decide(of_world[0], wide), exact.pairs().decide(of_world[1], sharp);
        threaded.pairs().decide(of_world[2], same);
        int colliding = 0;
        for (std::size_t i = 0; i < sharp.size(); ++i) {
            const PairOfModels& q = of_world[1][i];
            const bool meet = !brute_force(meshes[i % 3], meshes[(i / 3) % 3], q.a.pose, q.b.pose).empty();
            EXPECT_EQ(sharp[i].verdict, meet ? Verdict::colliding : Verdict::separate) << i;
            EXPECT_EQ(same[i].verdict, sharp[i].verdict) << i;
            if (meet) {
                EXPECT_EQ(wide[i].verdict, Verdict::within) << i;
            }
            colliding += meet;
        }
        EXPECT_GT(colliding, 15);
        EXPECT_LT(colliding, 50);
    }
}

TEST(PairsOfModels, BoundDistancesForAnyNumberOfThreads)
{
    const Mesh knot = make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 300);
    const std::vector<Mesh> meshes{knot, scaled(knot, 0.04, {0, 0, 0})};
    World one, three({.threads = 3});
    std::vector<PairOfModels> pairs, again;
    for (World* const world : {&one, &three}) {
        const ModelId models[] = {world->models().add(meshes[0]), world->models().add(meshes[1])};
        for (std::uint32_t i = 0; i < 40; ++i) {
            const Eigen::Isometry3d at = random_pose(i, 100);
            (world == &one ? pairs : again)
                .push_back({{models[i % 2], at}, {models[1], at * random_pose(i + 700, 0.8)}});
        }
    }
    std::vector<Distance> distances(pairs.size()), same(pairs.size()), near(pairs.size());
    one.pairs().distance(pairs, {.tolerance = 1e-3}, distances);
    three.pairs().distance(again, {.tolerance = 1e-3}, same);
    one.pairs().distance(pairs, {.cutoff = 0.1}, near);
    int apart = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        const Distance exact = one.pairs().distance(pairs[i].a, pairs[i].b);
        EXPECT_LE(distances[i].lower, exact.upper);
        EXPECT_GE(distances[i].upper, exact.lower);
        EXPECT_LE(distances[i].upper - distances[i].lower, 1e-3 + 1e-8);
        EXPECT_EQ(distances[i].lower, same[i].lower);
        EXPECT_EQ(distances[i].upper, same[i].upper);
        EXPECT_EQ(exact.upper == 0, !one.pairs().contacts(pairs[i].a, pairs[i].b).empty());
        EXPECT_EQ(std::isinf(near[i].upper), exact.lower > 0.1) << exact.lower;
        apart += exact.lower > 0.1;
    }
    EXPECT_GT(apart, 5);
    EXPECT_LT(apart, 35);
    EXPECT_THROW(one.pairs().distance(pairs, {.tolerance = -1}, distances), Error);
    EXPECT_THROW(one.pairs().distance(pairs, {}, {}), Error);
}

} // namespace
} // namespace oncollide::predicates_test
