// Robot::edge_clearance() against distances of many configurations of the edge.
#include <gtest/gtest.h>

#include "robots/long_arm.hpp"
#include "robots/small_robot.hpp"
#include "scenes/test_files.hpp"

namespace oncollide::edge_clearance_test {
namespace {

using test::add_bodies, test::expect_error, test::long_arm, test::numbers_of;

TEST(RobotEdgeClearance, IsBelowAllSamplesAndNearTheLeast)
{
    World world;
    add_bodies(world, 8, 3, 12);
    const Robot robot(world, long_arm(), random_pose(3, 0.2));
    constexpr std::size_t count = 30, samples = 400;
    constexpr double tolerance = 0.002;
    const std::vector<double> numbers = numbers_of(robot, 2 * count, 0.25);
    const std::size_t half = count * robot.width();
    const auto from = std::span(numbers).first(half), to = std::span(numbers).subspan(half);
    for (const bool self : {false, true}) {
        std::vector<RobotEdgeClearance> found(count);
        robot.edge_clearance(world, from, to, found, {.pairs = {.self = self}, .tolerance = tolerance});
        std::size_t apart = 0, inside = 0;
        RobotDistances at;
        for (std::size_t i = 0; i < count; ++i) {
            const RobotEdgeClearance& edge = found[i];
            EXPECT_LE(edge.lower, edge.upper);
            EXPECT_LE(edge.upper - edge.lower, tolerance + 1e-9) << i;
            std::vector<double> way;
            const auto add = [&](double share) {
                for (std::size_t n = 0; n < robot.width(); ++n)
                    way.push_back(std::lerp(from[i * robot.width() + n], to[i * robot.width() + n], share));
            };
            for (std::size_t k = 0; k <= samples; ++k) add(double(k) / samples);
            add(edge.at);
            robot.distances(world, way, at, {.pairs = {.self = self}, .gradients = false, .depths = false});
            for (std::size_t k = 0; k <= samples; ++k) ASSERT_GE(at.pairs[k].upper, edge.lower - 1e-9) << i << " " << k;
            const RobotDistance& there = at.pairs.back();
            EXPECT_NEAR(there.upper, edge.upper, 0.26 * tolerance) << i;
            EXPECT_TRUE(edge.upper == 0 || // where several pairs may meet
                        (there.link == edge.link && there.other == edge.other && there.body == edge.body))
                << i;
            apart += edge.lower > 0, inside += edge.at > 0 && edge.at < 1;
        }
        EXPECT_GT(apart, 3u);
        EXPECT_GT(inside, 3u);
    }
}

TEST(RobotEdgeClearance, HasTheSameBitsForAnyNumberOfThreads)
{
    std::vector<RobotEdgeClearance> found[2];
    for (const int threads : {1, 3}) {
        World world({.threads = threads});
        add_bodies(world, 8, 3, 12);
        const Robot robot(world, long_arm(), random_pose(3, 0.2));
        const std::vector<double> numbers = numbers_of(robot, 40, 0.25);
        auto& edges = found[threads > 1];
        edges.resize(20);
        robot.edge_clearance(world, std::span(numbers).first(20 * robot.width()),
                             std::span(numbers).subspan(20 * robot.width()), edges);
    }
    for (std::size_t i = 0; i < 20; ++i) {
        EXPECT_EQ(found[0][i].lower, found[1][i].lower) << i;
        EXPECT_EQ(found[0][i].upper, found[1][i].upper) << i;
        EXPECT_EQ(found[0][i].at, found[1][i].at) << i;
        EXPECT_EQ(found[0][i].link, found[1][i].link) << i;
    }
}

TEST(RobotEdgeClearance, OfNothingIsInfiniteAndOfAContactIsZero)
{
    RobotDescription description = long_arm();
    World world;
    const Robot robot(world, description);
    const std::vector<double> from(robot.width(), 0.0), to(robot.width(), 0.4);
    RobotEdgeClearance edge;
    robot.edge_clearance(world, from, to, {&edge, 1}, {.pairs = {.self = false}});
    EXPECT_EQ(edge.lower, std::numeric_limits<double>::infinity());
    EXPECT_EQ(edge.link, RobotFinding::no_link);
    // A plate that the arm passes between both ends.
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    std::vector<Eigen::Isometry3d> links(description.links.size());
    robot.link_poses(std::vector<double>(robot.width(), 0.17), links);
    pose.translation() = links[5].translation();
    const BodyId plate =
        world.bodies().add({.model = world.models().add(Box{{0.01, 0.01, 0.01}}), .pose = pose, .is_static = true});
    robot.edge_clearance(world, from, to, {&edge, 1}, {.pairs = {.self = false}});
    EXPECT_EQ(edge.lower, 0);
    EXPECT_EQ(edge.upper, 0);
    EXPECT_EQ(edge.body, plate);
    RobotFinding there;
    std::vector<double> at(robot.width(), 0.4 * edge.at);
    robot.check(world, at, {&there, 1}, {.self = false});
    EXPECT_EQ(there.verdict, Verdict::colliding);
    const RobotEdgeClearance before = edge;
    robot.edge_clearance(world, from, to, {&edge, 1}, {.pairs = {.self = false}, .most_tests = 1});
    EXPECT_LE(edge.lower, before.lower); // a limit widens the bounds
    expect_error(
        ErrorKind::usage,
        [&] {
            robot.edge_clearance(world, from, to, {&edge, 1}, {.tolerance = 0});
        },
        "above 0");
    expect_error(
        ErrorKind::usage,
        [&] {
            robot.edge_clearance(world, from, std::span(to).first(2), {&edge, 1});
        },
        "2 numbers");
}

} // namespace
} // namespace oncollide::edge_clearance_test
