// Absurd arguments of Robot: each is one clear Error.
#include <gtest/gtest.h>

#include "hostile/refused_calls.hpp"
#include <oncollide/robots/robot.hpp>

namespace oncollide::robot_api_test {
namespace {

using test::bad_poses, test::Calls, test::expect_refused, test::inf, test::nan;

TEST(HostileRobots, NumbersAndSizesAreChecked)
{
    RobotDescription description;
    description.name = "arm", description.links = {{"base", {}}, {"tip", {}}};
    const auto ball = std::make_shared<const Geometry>(Geometry{"ball", Shape(Sphere{0.1}), {}});
    for (RobotLink& link : description.links) link.collision = {{ball, Eigen::Isometry3d::Identity()}};
    RobotJoint joint;
    joint.name = "float", joint.kind = JointKind::floating, joint.child = 1;
    description.joints = {joint}, description.states = {{"home", "", {{0, {0, 0, 1, 0, 0, 0, 1}}}}};
    World world, other;
    Robot robot(world, description);
    const std::vector<double> good = robot.neutral();
    const auto with = [&](std::size_t i, double value) {
        std::vector<double> numbers = good;
        numbers[i] = value;
        return numbers;
    };
    std::vector<RobotFinding> one(1), two(2);
    std::vector<RobotEdgeFinding> edge(1);
    std::vector<Eigen::Isometry3d> poses(2), three(3);
    std::vector<double> few(3);
    Calls calls{
        {"width", [&] { robot.check(world, few, one); }},
        {"findings", [&] { robot.check(world, good, two); }},
        {"World", [&] { robot.check(other, good, one); }},
        {"ends", [&] { robot.check_edges(world, good, few, edge); }},
        {"poses", [&] { robot.link_poses(good, three); }},
        {"numbers", [&] { robot.link_poses(few, poses); }},
        {"state", [&] { robot.apply_state("hom", "", *std::make_unique<std::vector<double>>(7)); }},
        {"room", [&] { robot.apply_state("home", "", few); }},
        {"bodies first", [&] { robot.set_joints(world, good); }},
        {"body", [&] { static_cast<void>(robot.link_of(2)); }},
        {"bodies of another", [&] { robot.add_bodies(other); }},
        {"attach", [&] { robot.attach(world, ~0u, world.models().at(0), Eigen::Isometry3d::Identity()); }},
    };
    for (const double bad : {nan, inf, 2e9, -inf}) {
        const std::string name = std::to_string(bad);
        calls["check " + name] = [&, bad] { robot.check(world, with(0, bad), one); };
        calls["quaternion " + name] = [&, bad] { robot.check(world, with(6, bad), one); };
        calls["edge " + name] = [&, bad] { robot.check_edges(world, good, with(2, bad), edge); };
        calls["tolerance " + name] = [&, bad] { robot.check_edges(world, good, good, edge, {.tolerance = bad}); };
    }
    calls["no rotation"] = [&] { robot.check(world, with(6, 0), one); };
    for (const Eigen::Isometry3d& bad : bad_poses()) {
        if (bad.translation().x() == 1e300) continue; // an Error of the configurations
        calls["base " + std::to_string(calls.size())] = [&, bad] { robot.set_base(bad); };
        calls["object " + std::to_string(calls.size())] = [&, bad] {
            robot.attach(world, 1, world.models().at(0), bad);
        };
    }
    expect_refused(calls);
    robot.check(world, with(0, 1), one);
    EXPECT_EQ(one[0].verdict, Verdict::separate);
    robot.check_edges(world, with(0, 1), with(0, 2), edge, {.most_tests = 0});
    EXPECT_LE(edge[0].clear_until, 1.0);
    robot.set_base(Eigen::Isometry3d(Eigen::Translation3d(1e300, 0, 0)));
    expect_refused({{"far base", [&] { robot.check(world, good, one); }},
                    {"far base of an edge", [&] { robot.check_edges(world, good, good, edge); }},
                    {"far bodies", [&] { robot.add_bodies(world); }}});
}

} // namespace
} // namespace oncollide::robot_api_test
