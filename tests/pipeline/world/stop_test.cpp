// Settings::stop: a call that is stopped ends soon, loses no data, and leaves no trace.
#include <gtest/gtest.h>

#include <atomic>

#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>

#include "random_pose.hpp"

namespace oncollide {
namespace {

/// Returns true from the N-th call on, until it is reset.
struct StopAfter {
    std::atomic<int> calls = 0;
    int limit = 0;
    bool operator()() { return ++calls > limit; }
};

struct Way {
    const char* name;
    Settings settings;
};

class EveryWay : public ::testing::TestWithParam<Way> {
protected:
    static std::vector<BodyId> pile(World& world)
    {
        const ModelId knot = world.models().add(make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 600));
        std::vector<BodyId> bodies;
        for (std::uint32_t i = 0; i < 120; ++i)
            bodies.push_back(world.bodies().add({.model = knot, .pose = random_pose(i, 3.0)}));
        return bodies;
    }
};

TEST_P(EveryWay, AStoppedStepKeepsEveryPairAndTheNextOneIsWhole)
{
    StopAfter stop;
    Settings settings = GetParam().settings;
    World whole(settings);
    settings.stop = [&] { return stop(); };
    World stopped(settings);
    const std::vector<BodyId> bodies = pile(stopped), same_bodies = pile(whole);
    for (const int limit : {0, 3, 40}) {
        stop.calls = 0, stop.limit = limit;
        const FrameView part = stopped.step();
        int undecided = 0;
        for (const PairResult& pair : part.pairs) undecided += pair.verdict == Verdict::undecided;
        EXPECT_GT(undecided, 0) << limit;
        const FrameView all = whole.step();
        ASSERT_EQ(part.pairs.size(), all.pairs.size());
        for (std::size_t i = 0; i < all.pairs.size(); ++i) {
            if (part.pairs[i].verdict == Verdict::separate) {
                EXPECT_EQ(all.pairs[i].verdict, Verdict::separate) << i;
            }
            if (part.pairs[i].verdict == Verdict::undecided) {
                EXPECT_GE(part.pairs[i].bound, stopped.pairs().distance(part.pairs[i].a, part.pairs[i].b).lower) << i;
            }
        }
    }
    for (std::uint32_t i = 0; i < bodies.size(); i += 2) { // moves bodies, so that stored results of the last frame are
                                                           // used
        Eigen::Isometry3d pose = stopped.bodies().pose(bodies[i]);
        pose.translation().x() += 0.05;
        stopped.bodies().set_pose(bodies[i], pose), whole.bodies().set_pose(same_bodies[i], pose);
    }
    stop.limit = std::numeric_limits<int>::max();
    const FrameView again = stopped.step(), all = whole.step();
    ASSERT_EQ(again.pairs.size(), all.pairs.size());
    for (std::size_t i = 0; i < all.pairs.size(); ++i) EXPECT_EQ(again.pairs[i].verdict, all.pairs[i].verdict) << i;
}

TEST_P(EveryWay, AStoppedQueryKeepsEveryHit)
{
    StopAfter stop;
    Settings settings = GetParam().settings;
    settings.stop = [&] { return stop(); };
    World world(settings);
    pile(world);
    const ModelId ball = world.models().add(Sphere{2});
    const std::vector<QueryHit> part = world.space().overlaps(PlacedModel{ball});
    stop.limit = std::numeric_limits<int>::max();
    const std::vector<QueryHit> all = world.space().overlaps(PlacedModel{ball});
    ASSERT_FALSE(all.empty());
    EXPECT_GE(part.size(), all.size());
    for (const QueryHit& hit : part) EXPECT_EQ(hit.verdict, Verdict::undecided);
}

INSTANTIATE_TEST_SUITE_P(
    Stop, EveryWay,
    ::testing::Values(Way{"boxes", {.max_error = 0.01}}, Way{"spheres", {.depth = 6}},
                      Way{"exact", {.exact = ExactLevel::predicates, .threads = 3}},
                      Way{"both",
                          {.depth = 4, .exact = ExactLevel::predicates, .bounding_volume = BoundingVolume::sphere}},
                      Way{"spheres_on_threads", {.depth = 5, .threads = 3}},
                      Way{"solid", {.exact = ExactLevel::predicates, .mode = Mode::solid}},
                      Way{"fcl", {.max_error = 0.05, .exact = ExactLevel::fcl}}),
    [](const auto& way) { return std::string(way.param.name); });

TEST(Stop, QueriesInBatchesThatAreStoppedHaveCertifiedBounds)
{
    StopAfter stop{.limit = 5};
    World world({.max_error = 0.01, .stop = [&] { return stop(); }});
    const ModelId ball = world.models().add(make_sphere_mesh(1, 500));
    std::vector<PairOfModels> all;
    for (std::uint32_t i = 0; i < 500; ++i) all.push_back({{ball}, {ball, random_pose(i, 3)}});
    std::vector<Finding> results(all.size());
    world.pairs().decide(all, results);
    std::vector<Distance> distances(all.size(), Distance{.lower = 7, .upper = 7});
    stop.calls = 0;
    world.pairs().distance(all, {}, distances);
    EXPECT_NE(results[0].verdict, Verdict::undecided);
    EXPECT_EQ(results.back().verdict, Verdict::undecided);
    EXPECT_GE(results.back().bound, all.back().b.pose.translation().norm() - 2);
    EXPECT_LT(results.back().bound, 12);
    EXPECT_LT(distances[0].upper, 12);
    EXPECT_EQ(distances.back().lower, 0);
    EXPECT_EQ(distances.back().upper, std::numeric_limits<double>::infinity());
}

} // namespace
} // namespace oncollide
