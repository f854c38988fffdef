#include <oncollide/robots/kinematics.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include <oncollide/robots/robot.hpp>

namespace oncollide::kinematics_test {
namespace {

/// A tree in which each link hangs on one of the few before it.
RobotDescription random_tree(std::uint32_t links, std::uint32_t reach)
{
    std::mt19937 random(links);
    RobotDescription robot;
    robot.name = "tree";
    const auto ball = std::make_shared<const Geometry>(Geometry{"ball", Shape(Sphere{0.02}), {}});
    for (std::uint32_t i = 0; i < links; ++i) {
        robot.links.push_back({"link" + std::to_string(i), {{ball}}});
        if (i == 0) continue;
        RobotJoint joint;
        joint.name = "joint" + std::to_string(i), joint.kind = JointKind::revolute;
        joint.parent = i - 1 - random() % std::min(reach, i), joint.child = i;
        joint.lower = -1, joint.upper = 1;
        joint.origin.translation().x() = 0.1, joint.axis = i % 2 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitY();
        robot.joints.push_back(joint);
        robot.excluded.push_back({joint.parent, i});
    }
    return robot;
}

TEST(Kinematics, WaysHaveTheLinksBetweenAndTheirMiddle)
{
    for (const std::uint32_t reach : {1u, 3u, 60u}) {
        const Kinematics tree(random_tree(60, reach));
        std::vector<Kinematics::Way> ways;
        for (std::uint32_t a = 0; a < 60; ++a) {
            tree.ways_from(a, ways);
            ASSERT_EQ(ways.size(), 60u);
            for (std::uint32_t b = 0; b < 60; ++b) {
                const std::vector<std::uint32_t> between = tree.links_between(a, b);
                EXPECT_EQ(ways[b].links, between.size());
                EXPECT_TRUE(std::ranges::count(between, ways[b].middle));
                const std::size_t to_a = tree.links_between(a, ways[b].middle).size(),
                                  to_b = tree.links_between(ways[b].middle, b).size();
                EXPECT_EQ(to_a + to_b, between.size() + 1);
                EXPECT_LE(std::max(to_a, to_b) - std::min(to_a, to_b), 1u);
            }
        }
    }
}

/// The pairs of a long chain are seen from the middle; checks do not refute its edges.
TEST(Kinematics, ALongChainIsCheckedOnItsEdges)
{
    World world;
    const Robot robot(world, random_tree(80, 1));
    std::mt19937 random(2);
    std::size_t contacts = 0;
    for (int trial = 0; trial < 6; ++trial) {
        std::vector<double> from(robot.width(), 0.0), to(robot.width());
        for (std::size_t i = 0; i < to.size(); ++i) // it curls up
            to[i] = std::uniform_real_distribution(-0.1, 0.1)(random) + (i % 2 ? 0 : 0.08 * trial);
        RobotEdgeFinding edge;
        robot.check_edges(world, from, to, {&edge, 1});
        std::vector<double> samples;
        constexpr std::size_t count = 400;
        for (std::size_t k = 0; k <= count; ++k)
            for (std::size_t i = 0; i < to.size(); ++i) samples.push_back(to[i] * double(k) / count);
        std::vector<RobotFinding> found(count + 1);
        robot.check(world, samples, found);
        for (std::size_t k = 0; k <= count; ++k)
            EXPECT_TRUE(double(k) / count >= edge.clear_until || found[k].verdict == Verdict::separate)
                << trial << " " << k;
        contacts += edge.contact_by <= 1;
    }
    EXPECT_GT(contacts, 0u);
    EXPECT_LT(contacts, 6u);
}

} // namespace
} // namespace oncollide::kinematics_test
