// Queries of a World give the results of frames.
#include <array>
#include <map>
#include <thread>

#include <gtest/gtest.h>

#include <oncollide/pipeline/two_geometries.hpp>
#include <oncollide/pipeline/world.hpp>

#include "every_kind.hpp"
#include "pipeline/knots.hpp"
#include "random_pose.hpp"

namespace oncollide::world_test {
namespace {

TEST(World, GivesQueriesWhatAFrameWouldGiveABody)
{
    for (const ExactLevel exact : {ExactLevel::off, ExactLevel::predicates}) {
        World world({.depth = 5, .exact = exact});
        const ModelId shapes[] = {world.models().add(knot()), world.models().add(make_sphere_mesh(0.6, 300)),
                                  world.models().add(Shape(Capsule{0.3, 1}))};
        for (std::uint64_t i = 0; i < 80; ++i)
            world.bodies().add({.model = shapes[i % 3], .pose = random_pose(i, 4), .layer = i % 7 ? 1u : 2u});
        std::vector<PlacedModel> queries;
        for (std::uint64_t i = 0; i < 24; ++i) queries.push_back({shapes[i % 3], random_pose(i + 900, 4)});
        std::vector<std::vector<QueryHit>> beside(queries.size());
        std::vector<std::thread> threads;
        for (std::size_t t = 0; t < 3; ++t)
            threads.emplace_back([&, t] {
                for (std::size_t i = t; i < queries.size(); i += 3)
                    beside[i] = world.space().overlaps(queries[i], {.mask = 1});
            });
        for (std::thread& thread : threads) thread.join(); // the trees grew during the queries
        Lists<QueryHit> many;
        world.space().overlaps(queries, {.mask = 1}, many);
        ASSERT_EQ(many.offsets.size(), queries.size() + 1);
        std::size_t begin = 0;
        for (std::size_t i = 0; i < queries.size(); ++i) {
            // As the last body it is B of every pair in a frame, and A in a query: exact results are symmetric here.
            const BodyId added = world.bodies().add({.model = queries[i].model, .pose = queries[i].pose, .mask = 1});
            std::map<std::uint32_t, Verdict> expected;
            for (const PairResult& pair : world.step().pairs)
                if (pair.b == added && pair.verdict != Verdict::separate) expected[pair.a.slot] = pair.verdict;
            world.bodies().remove(added);
            std::map<std::uint32_t, Verdict> found, alone;
            for (; begin < many.offsets[i + 1]; ++begin) found[many.items[begin].body.slot] = many.items[begin].verdict;
            for (const QueryHit& hit : beside[i]) alone[hit.body.slot] = hit.verdict;
            EXPECT_EQ(found, expected) << i;
            EXPECT_EQ(alone, expected) << i;
        }
        EXPECT_GT(begin, 10u);
    }
}

TEST(World, FindsWhatSegmentsAndBoxesReach)
{
    World world({.exact = ExactLevel::predicates});
    const ModelId ball = world.models().add(make_sphere_mesh(1, 500));
    const BodyId near = world.bodies().add({.model = ball, .pose = at(5)}),
                 far = world.bodies().add({.model = ball, .pose = at(20)});
    const auto through = world.space().overlaps(Segment{{0, 0, 0}, {10, 0, 0}});
    ASSERT_EQ(through.size(), 1u);
    EXPECT_EQ(through[0].body, near);
    EXPECT_TRUE(world.space().overlaps(Segment{{0, 3, 0}, {30, 3, 0}}).empty());
    Aabb box;
    box.min = Eigen::Vector3d(15, -5, -5), box.max = Eigen::Vector3d(25, 5, 5);
    const auto inside = world.space().overlaps(box);
    ASSERT_EQ(inside.size(), 1u);
    EXPECT_EQ(inside[0].body, far);
    EXPECT_EQ(inside[0].kind, ContactKind::enclosed);
    world.bodies().set_pose(far, at(50));
    EXPECT_TRUE(world.space().overlaps(box).empty()) << "queries see changes before the next step";
    EXPECT_EQ(world.space().overlaps(box, {.layer = 2, .mask = 2}).size(), 0u);
}

TEST(World, QueriesSegmentsAndBoxesWhereSpheresRefine)
{
    World world({.max_error = 0.05});
    const ModelId ball = world.models().add(make_sphere_mesh(1, 500));
    const BodyId near = world.bodies().add({.model = ball, .pose = at(5)});
    for (int repeat = 0; repeat < 3; ++repeat) {
        const auto through = world.space().overlaps(Segment{{0, 0, 0}, {10, 0, 0}});
        ASSERT_EQ(through.size(), 1u);
        EXPECT_EQ(through[0].body, near);
        EXPECT_EQ(through[0].verdict, Verdict::colliding) << "segments are exact";
        EXPECT_TRUE(world.space().overlaps(Segment{{0, -2, 0.2}, {7, 3, 0.2}}).empty()) << "the boxes overlap";
        EXPECT_EQ(world.space().overlaps(Aabb{{5.5, -0.1, -0.1}, {7, 0.1, 0.1}}).size(), 1u);
        world.models().add(make_box_mesh({1, 1, 1}));
    }
}

TEST(World, BoundsDistancesOfMeshesAndShapes)
{
    World world;
    const BodyId a = world.bodies().add({.model = world.models().add(make_box_mesh({1, 1, 1}))});
    const BodyId b = world.bodies().add({.model = world.models().add(Shape(Sphere{1})), .pose = at(5)});
    const BodyId c = world.bodies().add({.model = world.models().add(Shape(Box{{0.1, 0.1, 0.1}})), .pose = at(5)});
    const Distance apart = world.pairs().distance(a, b), inside = world.pairs().distance(b, c);
    EXPECT_LE(apart.lower, 3);
    EXPECT_GE(apart.upper, 3);
    EXPECT_NEAR(apart.lower, apart.upper, 0.03);
    EXPECT_EQ(inside.lower, 0);
    EXPECT_LT(inside.upper, 0.02);
    EXPECT_TRUE(world.pairs().contacts(a, b).empty());
    EXPECT_THROW(world.pairs().distance(a, b, {.tolerance = -1}), Error);
}

TEST(TwoGeometries, OfEveryTwoKindsAnswerAsAWorldDoes)
{
    for (std::size_t kind = 0; kind < kinds * kinds; ++kind) {
        const std::array<std::shared_ptr<Geometry>, 2> two{
            std::make_shared<Geometry>(Geometry{"a", draw_geometry(kind % kinds, 7), {}}),
            std::make_shared<Geometry>(Geometry{"b", draw_geometry(kind / kinds, 8), {}})};
        const Eigen::Isometry3d pose_a = random_pose(kind, 20), pose_b = pose_a * random_pose(kind + 900, 1.5);
        World world;
        const PlacedModel a{world.models().add(two[0]), pose_a}, b{world.models().add(two[1]), pose_b};
        EXPECT_EQ(collide(two[0], pose_a, two[1], pose_b).verdict, world.pairs().decide(a, b).verdict) << kind;
        const Distance found = distance(two[0], pose_a, two[1], pose_b), same = world.pairs().distance(a, b);
        EXPECT_EQ(std::pair(found.lower, found.upper), std::pair(same.lower, same.upper)) << kind;
        EXPECT_EQ(contacts(two[0], pose_a, two[1], pose_b).size(), world.pairs().contacts(a, b).size()) << kind;
        EXPECT_EQ(penetration(two[0], pose_a, two[1], pose_b).depth, world.pairs().penetration(a, b).depth) << kind;
    }
    EXPECT_EQ(collide(Sphere{1}, at(0), make_box_mesh({1, 1, 1}), at(1.5)).verdict, Verdict::colliding);
}

TEST(Meshes, AreTestedInOneLine)
{
    const Mesh box = make_box_mesh({1, 1, 1});
    EXPECT_EQ(collide(box, at(0), box, at(1.5)).verdict, Verdict::colliding);
    EXPECT_EQ(collide(box, at(0), box, at(2.5)).verdict, Verdict::separate);
    EXPECT_NEAR(distance(box, at(0), box, at(2.5)).upper, 0.5, 1e-9);
    EXPECT_FALSE(contacts(box, at(0), box, at(1.5, 0.3, 0.2)).empty());
    Eigen::Isometry3d wrong = at(0);
    wrong.linear()(0, 0) = 3;
    EXPECT_THROW(collide(box, wrong, box, at(0)), Error);
}

} // namespace
} // namespace oncollide::world_test
