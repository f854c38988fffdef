// decide(), distance(), contacts() and penetration(): of bodies, of models at poses, one and many, with one result
// each.
#include <gtest/gtest.h>

#include <map>
#include <thread>

#include <oncollide/base/error.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>

#include "random_pose.hpp"

namespace oncollide {
namespace {

/// Bodies at random poses, and the same pairs as bodies, as models at poses and as columns.
struct Crowd {
    World world;
    std::vector<BodyId> bodies;
    std::vector<PairOfBodies> of_bodies;
    std::vector<PairOfModels> of_models;
    std::vector<ModelId> a, b;
    std::vector<double> poses_a, poses_b;

    explicit Crowd(const Settings& settings, bool meshes_only = false) : world(settings)
    {
        std::vector<ModelId> models{world.models().add(make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 300)),
                                    world.models().add(make_box_mesh({1, 0.5, 1})),
                                    world.models().add(Shape(Box{{0.5, 1, 1}}))};
        if (!meshes_only) models.push_back(world.models().add(Shape(Capsule{0.5, 1})));
        for (std::uint64_t i = 0; i < 16; ++i)
            bodies.push_back(world.bodies().add({.model = models[i % models.size()], .pose = random_pose(i, 2)}));
        const auto append = [](std::vector<double>& rows, const Eigen::Isometry3d& pose) {
            for (int r = 0; r < 4; ++r)
                for (int c = 0; c < 4; ++c) rows.push_back(pose(r, c));
        };
        for (std::size_t i = 0; i < bodies.size(); ++i)
            for (std::size_t k = 0; k < i; ++k) {
                of_bodies.push_back({bodies[k], bodies[i]});
                of_models.push_back({{world.bodies().model(bodies[k]), world.bodies().pose(bodies[k])},
                                     {world.bodies().model(bodies[i]), world.bodies().pose(bodies[i])}});
                a.push_back(world.bodies().model(bodies[k])), b.push_back(world.bodies().model(bodies[i]));
                append(poses_a, world.bodies().pose(bodies[k])), append(poses_b, world.bodies().pose(bodies[i]));
            }
    }
    PairOfColumns columns() const { return {{a, poses_a}, {b, poses_b}}; }
};

class PairQueries : public ::testing::TestWithParam<Settings> {};

TEST_P(PairQueries, DecideAsAFrameDoes)
{
    Crowd crowd(GetParam());
    std::map<std::pair<std::uint32_t, std::uint32_t>, Finding> frame;
    for (const PairResult& pair : crowd.world.step().pairs) frame[{pair.a.slot, pair.b.slot}] = pair;
    const std::size_t count = crowd.of_bodies.size();
    std::vector<Finding> bodies(count), models(count), columns(count);
    crowd.world.pairs().decide(crowd.of_bodies, bodies);
    crowd.world.pairs().decide(crowd.of_models, models);
    crowd.world.pairs().decide(crowd.columns(), columns);
    int colliding = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const auto [a, b] = crowd.of_bodies[i];
        EXPECT_EQ(bodies[i], models[i]) << i;
        EXPECT_EQ(bodies[i], columns[i]) << i;
        EXPECT_EQ(bodies[i], crowd.world.pairs().decide(a, b)) << i;
        EXPECT_EQ(bodies[i], crowd.world.pairs().decide(a, crowd.of_models[i].b)) << "a body and a model at a pose";
        const auto found = frame.find({a.slot, b.slot});
        EXPECT_EQ(bodies[i].verdict, found == frame.end() ? Verdict::separate : found->second.verdict) << i;
        colliding += bodies[i].verdict != Verdict::separate;
    }
    EXPECT_GT(colliding, 10);
    EXPECT_LT(colliding, int(count) - 10);
}

TEST_P(PairQueries, MeasureDistancesAndListContactsAlike)
{
    Crowd crowd(GetParam());
    const std::size_t count = crowd.of_bodies.size();
    std::vector<Distance> bodies(count), models(count), columns(count);
    crowd.world.pairs().distance(crowd.of_bodies, {.tolerance = 1e-3}, bodies);
    crowd.world.pairs().distance(crowd.of_models, {.tolerance = 1e-3}, models);
    crowd.world.pairs().distance(crowd.columns(), {.tolerance = 1e-3}, columns);
    Lists<Contact> of_bodies, of_models;
    crowd.world.pairs().contacts(crowd.of_bodies, of_bodies);
    crowd.world.pairs().contacts(crowd.of_models, of_models);
    ASSERT_EQ(of_bodies.offsets.size(), count + 1);
    EXPECT_EQ(of_bodies.offsets.front(), 0u);
    EXPECT_EQ(of_bodies.offsets.back(), of_bodies.items.size());
    EXPECT_EQ(of_bodies.offsets, of_models.offsets);
    for (std::size_t i = 0; i < count; ++i) {
        const auto [a, b] = crowd.of_bodies[i];
        const Distance one = crowd.world.pairs().distance(crowd.of_models[i].a, b, {.tolerance = 1e-3});
        for (const Distance* d : {&bodies[i], &models[i], &columns[i]}) {
            EXPECT_EQ(d->lower, one.lower) << i;
            EXPECT_EQ(d->upper, one.upper) << i;
        }
        EXPECT_EQ(crowd.world.pairs().contacts(a, b).size(), of_bodies.offsets[i + 1] - of_bodies.offsets[i]) << i;
    }
}

TEST_P(PairQueries, MeasurePenetrationAlike)
{
    Crowd crowd(GetParam(), true);
    const std::size_t count = crowd.of_bodies.size();
    std::vector<Penetration> bodies(count), models(count);
    crowd.world.pairs().penetration(crowd.of_bodies, bodies);
    crowd.world.pairs().penetration(crowd.of_models, models);
    for (std::size_t i = 0; i < count; ++i) {
        const auto [a, b] = crowd.of_bodies[i];
        EXPECT_EQ(bodies[i].depth, models[i].depth) << i;
        EXPECT_EQ(bodies[i].depth, crowd.world.pairs().penetration(a, crowd.of_models[i].b).depth) << i;
    }
}

TEST_P(PairQueries, FindAllBodiesWithinADistance)
{
    Crowd crowd(GetParam());
    const ModelId ball = crowd.world.models().add(Shape(Sphere{0.1}));
    std::size_t near = 0;
    for (std::uint64_t k = 0; k < 20; ++k) {
        const PlacedModel query{ball, random_pose(k + 500, 3)};
        const auto found = crowd.world.space().distances(query, {}, {.cutoff = 0.5});
        std::map<std::uint32_t, double> expected;
        for (const BodyId body : crowd.bodies)
            if (const double d = crowd.world.pairs().distance(PlacedModel{ball, query.pose}, body).lower; d <= 0.5)
                expected[body.slot] = d;
        ASSERT_EQ(found.size(), expected.size()) << k;
        for (const BodyDistance& one : found) EXPECT_EQ(one.distance.lower, expected.at(one.body.slot)) << k;
        near += found.size();
    }
    EXPECT_GT(near, 10u);
    EXPECT_THROW(crowd.world.space().distances({ball}, {}, {}), Error);
}

INSTANTIATE_TEST_SUITE_P(Every, PairQueries,
                         ::testing::Values(Settings{}, Settings{.exact = ExactLevel::predicates, .threads = 3},
                                           Settings{.depth = 5},
                                           Settings{.clearance = 0.1, .exact = ExactLevel::predicates}));

// To be run under the thread sanitizer, too.
TEST(ConstMembers, AreSafeBesideQueries)
{
    for (const Settings& settings : {Settings{.exact = ExactLevel::predicates}, Settings{.depth = 5}}) {
        Crowd crowd(settings);
        const World& world = crowd.world;
        std::vector<std::thread> threads;
        for (std::uint64_t t = 0; t < 2; ++t)
            threads.emplace_back([&, t] {
                for (std::uint64_t i = 0; i < 20; ++i) {
                    world.space().overlaps(PlacedModel{crowd.a[i], random_pose(100 * t + i, 2)});
                    world.space().overlaps(Segment{{-3, 0, 0}, {3, 0.1 * double(i), 0}});
                }
            });
        threads.emplace_back([&] {
            for (int i = 0; i < 20; ++i) {
                const WorldInfo info = world.inspect();
                EXPECT_EQ(info.bodies, crowd.bodies.size());
                EXPECT_GT(info.bytes, 0u);
                EXPECT_EQ(info.frames, 0u);
            }
        });
        threads.emplace_back([&] {
            for (const BodyId body : crowd.bodies) {
                EXPECT_TRUE(world.bodies().contains(body) && world.models().contains(world.bodies().model(body)));
                world.models().closed(world.bodies().model(body)), world.bodies().pose(body), world.bodies().user(body),
                    world.bodies().is_static(body);
                world.bodies().filter(body).layer, world.bodies().filter(body).mask, world.bodies().filter(body).group;
                world.bodies().excluded(body, crowd.bodies.front()),
                    world.pairs().max_error(body, crowd.bodies.front());
                world.bodies().at(body.slot), world.models().at(0), world.models().size(), world.bodies().size(),
                    world.settings();
                world.hash(), all_stage_names();
            }
        });
        threads.emplace_back([&] {
            std::vector<Finding> found(crowd.of_bodies.size());
            std::vector<Distance> distances(crowd.of_bodies.size());
            Lists<Contact> lists;
            world.pairs().decide(crowd.of_bodies, found);
            world.pairs().distance(crowd.of_bodies, {}, distances);
            world.pairs().contacts(crowd.of_bodies, lists);
            world.space().distances({crowd.a[0]}, {}, {.cutoff = 0.5});
            world.pairs().penetration(crowd.bodies[0], crowd.bodies[1]);
        });
        for (std::thread& thread : threads) thread.join();
    }
}

} // namespace
} // namespace oncollide
