// How frames run: on which executor, with which memory and geometry.
#include <algorithm>
#include <functional>

#include <gtest/gtest.h>

#include <oncollide/base/executor.hpp>
#include <oncollide/pipeline/world.hpp>

#include "allocations.hpp"
#include "pipeline/knots.hpp"
#include "random_pose.hpp"

namespace oncollide::world_test {
namespace {

/// Replaces an application's threads, without threads: tasks run one after the other, the last first.
class CountingExecutor final : public Executor {
public:
    int threads() const override { return 3; }
    void run(int tasks, const std::function<void(int)>& work) override
    {
        loops += 1, most = std::max(most, tasks);
        while (tasks--) work(tasks);
    }
    int loops = 0, most = 0;
};

TEST(World, RunsItsLoopsOnTheExecutorOfItsSettings)
{
    CountingExecutor executor;
    const auto run = [](const Settings& settings) {
        World world(settings);
        const ModelId model = world.models().add(knot());
        std::vector<BodySpec> bodies(200);
        std::vector<PlacedModel> queries;
        std::vector<BodyId> ids(bodies.size());
        for (std::size_t i = 0; i < bodies.size(); ++i) {
            bodies[i] = {.model = model, .pose = at(1.5 * double(i % 20), 1.5 * double(i / 20))};
            queries.push_back({model, bodies[i].pose});
        }
        world.bodies().add(bodies, ids);
        Lists<QueryHit> hits;
        world.space().overlaps(queries, {}, hits);
        world.step();
        world.bodies().set_pose(ids[0], at(0.5, 0));
        const std::uint64_t hash = world.step().hash;
        return std::pair(hash, hits.items.size());
    };
    const auto alone = run({.depth = 4}), spread = run({.depth = 4, .threads = 0, .executor = &executor});
    EXPECT_EQ(alone, spread);
    EXPECT_GT(executor.loops, 2);
    EXPECT_EQ(executor.most, 3); // the meaning of threads = 0

    executor.loops = 0;
    World many({.threads = 0, .executor = &executor});
    const ModelId model = many.models().add(knot());
    const std::vector<PairOfModels> pairs(500, {{model, at(0)}, {model, at(1)}});
    std::vector<Finding> results(pairs.size());
    many.pairs().decide(pairs, results);
    EXPECT_GT(executor.loops, 0);
}

TEST(World, AllocatesNothingInAWarmFrameWithoutAdditions)
{
    World world({.depth = 5, .exact = ExactLevel::predicates, .age_limit = 100000});
    const ModelId model = world.models().add(knot());
    std::vector<BodyId> ids;
    for (std::uint64_t i = 0; i < 100; ++i)
        ids.push_back(world.bodies().add({.model = model, .pose = random_pose(i, 5)}));
    std::vector<Eigen::Isometry3d> poses(ids.size());
    for (int lap = 0; lap < 4; ++lap)
        for (std::uint64_t frame = 0; frame < 6; ++frame) {
            for (std::uint64_t i = 0; i < ids.size(); ++i) {
                poses[i] = random_pose(i, 5);
                poses[i].translation().x() += 0.002 * double(frame);
            }
            const std::size_t before = allocations;
            world.bodies().set_pose(ids, poses);
            world.step();
            if (lap == 3) {
                EXPECT_EQ(allocations - before, 0u) << "frame " << frame;
            }
        }
}

TEST(World, TouchesNoGeometryOfBodiesThatMayNotCollide)
{
    World world({.exact = ExactLevel::predicates});
    const ModelId model = world.models().add(make_sphere_mesh(1, 500));
    for (std::uint32_t robot = 0; robot < 100; ++robot) {
        std::vector<BodyId> links;
        for (int link = 0; link < 12; ++link)
            links.push_back(
                world.bodies().add({.model = model, .pose = at(30.0 * robot, link), .group = robot % 2 ? robot : 0}));
        if (robot % 2 == 0)
            for (std::size_t i = 0; i < links.size(); ++i)
                for (std::size_t j = 0; j < i; ++j) world.bodies().exclude(links[i], links[j]);
    }
    const FrameView frame = world.step();
    EXPECT_TRUE(frame.pairs.empty());
    EXPECT_EQ(frame.trees.node_pairs, 0u);
    EXPECT_EQ(frame.trees.nodes, 0u);
}

} // namespace
} // namespace oncollide::world_test
