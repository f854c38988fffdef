#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "robots/small_robot.hpp"
#include <oncollide/robots/kinematics.hpp>
#include <oncollide/robots/robot.hpp>

namespace oncollide::robot_test {
namespace {

using Eigen::Isometry3d;
using Eigen::Translation3d;
using Eigen::Vector3d;
using test::add_posts, test::random_numbers, test::SmallRobot;

class RobotEdges : public ::testing::Test {
protected:
    RobotEdges()
        : description(load_robot(files.urdf, {.srdf = files.srdf, .packages = {{"robot", files.folder().path()}}}))
    {
    }
    SmallRobot files;
    RobotDescription description;
};

std::vector<double> between(std::span<const double> from, std::span<const double> to, double share)
{
    std::vector<double> numbers(from.size());
    for (std::size_t i = 0; i < from.size(); ++i) numbers[i] = from[i] + share * (to[i] - from[i]);
    return numbers;
}

TEST_F(RobotEdges, NoSampleBeforeTheBoundCollidesAndContactsAreReal)
{
    for (const double clearance : {0.0, 0.01}) {
        World world({.clearance = clearance, .exact = ExactLevel::predicates});
        add_posts(world);
        const Robot robot(world, description);
        constexpr std::size_t count = 300, samples = 1000;
        const std::vector<double> from = random_numbers(2 * count), to(from.begin() + 3 * count, from.end());
        std::vector<RobotEdgeFinding> found(count);
        const RobotEdgeCheck what{.tolerance = 1e-3};
        robot.check_edges(world, std::span(from).first(3 * count), to, found, what);
        std::size_t separate = 0, later = 0, undecided = 0;
        std::vector<double> numbers;
        std::vector<RobotFinding> at(samples + 1);
        for (std::size_t i = 0; i < count; ++i) {
            const auto a = std::span(from).subspan(3 * i, 3), b = std::span(to).subspan(3 * i, 3);
            const RobotEdgeFinding& edge = found[i];
            if (edge.contact_by <= 1) {
                RobotFinding there;
                robot.check(world, between(a, b, edge.contact_by), {&there, 1});
                EXPECT_EQ(there.verdict, edge.verdict) << i;
                EXPECT_LE(edge.clear_until, edge.contact_by);
            }
            later += edge.contact_by > 0 && edge.contact_by <= 1;
            separate += edge.verdict == Verdict::separate, undecided += edge.verdict == Verdict::undecided;
            if (edge.clear_until == 0) continue;
            numbers.clear();
            for (std::size_t k = 0; k <= samples; ++k) {
                const auto sample = between(a, b, static_cast<double>(k) / samples * edge.clear_until);
                numbers.insert(numbers.end(), sample.begin(), sample.end());
            }
            robot.check(world, numbers, at);
            for (std::size_t k = 0; k < samples + (edge.clear_until == 1); ++k)
                ASSERT_EQ(at[k].verdict, Verdict::separate) << "edge " << i << ", sample " << k;
            if (edge.verdict == Verdict::separate) {
                EXPECT_EQ(edge.clear_until, 1);
                EXPECT_EQ(edge.link, RobotFinding::no_link);
            }
        }
        EXPECT_GT(separate, 20u); // the test tests something
        EXPECT_GT(later, 20u);
        EXPECT_LE(undecided, 3u);
    }
}

TEST_F(RobotEdges, TheFirstContactIsBracketed)
{
    World world;
    // The arm, stretched out above the base, bends until it meets a wire.
    const double height = 1.0;
    world.bodies().add(
        {.model = world.models().add(Box{{1e-6, 1, 1e-6}}), .pose = Isometry3d(Translation3d(0.3, 0, height))});
    const Robot robot(world, description);
    const std::vector<double> from{0, 0, 0.05}, to{0, 2, 0.05};
    RobotEdgeFinding found;
    robot.check_edges(world, from, to, {&found, 1}, {.tolerance = 1e-6});
    EXPECT_EQ(found.verdict, Verdict::colliding);
    EXPECT_LE(found.contact_by - found.clear_until, 1e-6);
    EXPECT_GT(found.clear_until, 0.1);
    EXPECT_EQ(found.other, RobotFinding::no_link);
    EXPECT_TRUE(world.bodies().contains(found.body));
    RobotEdgeFinding any;
    robot.check_edges(world, from, to, {&any, 1}, {.tolerance = 1e-6, .first = false});
    EXPECT_EQ(any.verdict, Verdict::colliding);
    EXPECT_LE(any.clear_until, found.contact_by);
    EXPECT_GE(any.contact_by, found.clear_until);
    // A few tests leave the rest open, and say so.
    RobotEdgeFinding cut;
    robot.check_edges(world, from, to, {&cut, 1}, {.tolerance = 1e-6, .most_tests = 1});
    EXPECT_EQ(cut.verdict, Verdict::undecided);
    EXPECT_LE(cut.clear_until, found.clear_until);
}

/// A ball on an arm of two turning joints and one sliding joint, among small balls that stand around its base.
RobotDescription arm_among_balls()
{
    RobotDescription robot;
    robot.name = "among balls";
    const auto ball = [](double radius, double x, double y, double z) {
        return LinkGeometry{std::make_shared<const Geometry>(Geometry{"ball", Shape{Sphere{radius}}, {}}),
                            Isometry3d(Translation3d(x, y, z))};
    };
    robot.links = {{"base", {}}, {"turn", {}}, {"arm", {}}, {"tip", {ball(0.01, 0.1, 0, 0)}}};
    std::mt19937 random(4);
    const auto any = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
    for (int i = 0; i < 80; ++i) { // where the tip goes
        const double pan = any(-4, 4), lift = any(-4, 4), reach = any(0.3, 0.6), out = 0.5 + reach * std::cos(lift);
        robot.links[0].collision.push_back(
            ball(0.02, out * std::cos(pan), out * std::sin(pan), -reach * std::sin(lift)));
    }
    const auto joint = [&](const char* name, JointKind kind, std::uint32_t parent, double x, const Vector3d& axis,
                           double lower, double upper) {
        RobotJoint made;
        made.name = name, made.kind = kind, made.parent = parent, made.child = parent + 1;
        made.origin = Translation3d(x, 0, 0), made.axis = axis, made.lower = lower, made.upper = upper;
        robot.joints.push_back(made);
    };
    joint("pan", JointKind::continuous, 0, 0, Vector3d::UnitZ(), -INFINITY, INFINITY);
    joint("lift", JointKind::revolute, 1, 0.5, Vector3d::UnitY(), -6, 6);
    joint("slide", JointKind::prismatic, 2, 0.2, Vector3d::UnitX(), 0, 0.3);
    return robot;
}

TEST_F(RobotEdges, WhatCellsOfJointsHideIsNoContact)
{
    constexpr std::size_t count = 150, samples = 4000;
    std::mt19937 random(11);
    const auto any = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
    std::vector<double> from, to;
    for (std::size_t i = 0; i < count; ++i) {
        const double length = i % 3 == 0 ? 4 : 0.6;
        for (const double limit : {9.0, 6.0}) // turns more than once, and out of the limits
            from.push_back(any(-limit, limit)), to.push_back(from.back() + any(-length, length));
        from.push_back(any(-0.05, 0.35)), to.push_back(i % 5 == 0 ? from.back() : any(-0.05, 0.35));
    }
    std::vector<RobotEdgeFinding> found(count), again(count);
    std::vector<RobotFinding> at(samples + 1);
    const RobotEdgeCheck what{.pairs = {.environment = false}, .tolerance = 1e-4};
    for (const double clearance : {0.0, 0.015}) {
        World world({.clearance = clearance, .threads = 1});
        Robot robot(world, arm_among_balls());
        for (const bool holds : {false, true}) {
            if (holds) // cells that are known without the object do not count
                robot.attach(world, 3, world.models().add(Sphere{0.03}), Isometry3d(Translation3d(0.2, 0.1, 0)));
            robot.check_edges(world, from, to, found, what);
            std::size_t separate = 0, later = 0;
            for (std::size_t i = 0; i < count; ++i) {
                const auto a = std::span(from).subspan(3 * i, 3), b = std::span(to).subspan(3 * i, 3);
                std::vector<double> numbers;
                for (std::size_t k = 0; k <= samples; ++k) {
                    const auto sample = between(a, b, static_cast<double>(k) / samples);
                    numbers.insert(numbers.end(), sample.begin(), sample.end());
                }
                robot.check(world, numbers, at, what.pairs);
                const auto first = std::ranges::find_if(at, [](auto& f) { return f.verdict != Verdict::separate; });
                if (first == at.end()) {
                    separate += found[i].verdict == Verdict::separate;
                    continue;
                }
                const double share = static_cast<double>(first - at.begin()) / samples;
                ASSERT_NE(found[i].verdict, Verdict::separate) << "edge " << i << " touches at " << share;
                ASSERT_LE(found[i].clear_until, share) << "edge " << i;
                later += share > 0;
            }
            EXPECT_GT(separate, count / 10);
            EXPECT_GT(later, count / 10);
            robot.check_edges(world, from, to, again, what); // all cells are known now
            for (std::size_t i = 0; i < count; ++i) {
                EXPECT_EQ(again[i].clear_until, found[i].clear_until) << i;
                EXPECT_EQ(again[i].contact_by, found[i].contact_by) << i;
            }
        }
    }
}

/// A speck at the end of an arm that turns around one axis passes another speck, far smaller than any window. No test
/// of windows may lose the window of the contact.
TEST_F(RobotEdges, ASpeckOnTheWayIsNeverLost)
{
    constexpr double arm = 0.6;
    std::mt19937 random(5);
    const auto any = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
    const auto speck = [](bool mesh) {
        return mesh ? std::make_shared<const Geometry>(Geometry{"box", make_box_mesh(Vector3d::Constant(2e-5)), {}})
                    : std::make_shared<const Geometry>(Geometry{"ball", Shape{Sphere{2e-5}}, {}});
    };
    for (int trial = 0; trial < 96; ++trial) {
        const bool mesh = trial % 2, self = trial / 2 % 2, many = trial / 4 % 2;
        const int beside = trial / 8 % 3; // 1: above the way, 2: outside, within the clearance
        World world({.clearance = beside ? 0.0101 : 0.0, .threads = 1});
        const double angle = any(-3, 3);
        const double out = arm + (beside == 2 ? 0.01 : 0);
        const Isometry3d there(Translation3d(out * std::cos(angle), out * std::sin(angle), beside == 1 ? 0.01 : 0));
        RobotDescription made;
        made.name = "arm", made.links = {{"base", {}}};
        const std::uint32_t joints = many ? 4 : 1; // a grid over joints covers at most three
        for (std::uint32_t i = 0; i < joints; ++i) {
            RobotJoint joint;
            joint.name = "turn " + std::to_string(i), joint.kind = JointKind::continuous;
            joint.parent = i, joint.child = i + 1, joint.axis = Vector3d::UnitZ();
            made.joints.push_back(joint), made.links.push_back({"link " + std::to_string(i), {}});
        }
        made.links.back().collision = {{speck(mesh), Isometry3d(Translation3d(arm, 0, 0))}};
        if (self)
            made.links[0].collision = {{speck(mesh), there}};
        else
            world.bodies().add({.model = world.models().add(speck(mesh)), .pose = there});
        const Robot robot(world, made);
        std::vector<double> from, to;
        constexpr std::size_t count = 100;
        for (std::size_t i = 0; i < count; ++i) {
            const double longest = i % 2 ? 0.5 : 0.05;
            double before = any(-longest, 0), after = any(0, longest);
            if (i % 4 < 2) std::swap(before, after);
            for (std::uint32_t j = 0; j < joints; ++j) { // the angles of all joints are added
                from.push_back((angle + before) / joints), to.push_back((angle + after) / joints);
            }
        }
        std::vector<RobotEdgeFinding> found(count);
        robot.check_edges(world, from, to, found, {.tolerance = 1e-5});
        for (std::size_t i = 0; i < count; ++i)
            ASSERT_NE(found[i].verdict, Verdict::separate) << "trial " << trial << ", edge " << i;
    }
}

TEST_F(RobotEdges, AWireBetweenSamplesIsFound)
{
    World world;
    world.bodies().add(
        {.model = world.models().add(Box{{1e-6, 1e-6, 1}}), .pose = Isometry3d(Translation3d(0.25, 0.25, 1))});
    const Robot robot(world, description);
    const std::vector<double> from{-0.75, 1.5, 0.05}, to{0.85, 1.5, 0.05};
    std::size_t sampled = 0;
    for (int k = 0; k <= 10; ++k) {
        RobotFinding at;
        robot.check(world, between(from, to, 0.1 * k), {&at, 1});
        sampled += at.verdict == Verdict::colliding;
    }
    EXPECT_EQ(sampled, 0u);
    RobotEdgeFinding found;
    robot.check_edges(world, from, to, {&found, 1});
    EXPECT_EQ(found.verdict, Verdict::colliding);
}

/// A ball just outside the curved way of a small tool, which the straight way between two poses does not touch.
TEST_F(RobotEdges, ABallThatTheBentWayGrazesIsFound)
{
    World world;
    Robot robot(world, description);
    const double tool = 0.001, ball = 0.001, depth = 1e-5;
    const Isometry3d at_finger(Translation3d(0, 0, 0.3));
    robot.attach(world, 3, world.models().add(Sphere{tool}), at_finger);
    const BodyId body = world.bodies().add({.model = world.models().add(Sphere{ball})});
    const std::vector<double> numbers = random_numbers(400);
    std::size_t tested = 0;
    for (std::size_t i = 0; i + 1 < numbers.size() / 3; i += 2) {
        const auto from = std::span(numbers).subspan(3 * i, 3), to = std::span(numbers).subspan(3 * i + 3, 3);
        const double time = 0.2 + 0.6 * static_cast<double>(i) / 400, step = 1e-3;
        const auto centre = [&](double at) {
            std::vector<Isometry3d> poses(6);
            robot.link_poses(between(from, to, at), poses);
            return Vector3d((poses[3] * at_finger).translation());
        };
        const Vector3d bend = centre(time - step) + centre(time + step) - 2 * centre(time);
        const Vector3d outward = -bend.normalized();
        world.bodies().set_pose(body, Isometry3d(Translation3d(centre(time) + (tool + ball - depth) * outward)));
        RobotEdgeFinding found;
        robot.check_edges(world, from, to, {&found, 1}, {.pairs = {.self = false}});
        EXPECT_NE(found.verdict, Verdict::separate) << i;
        EXPECT_LE(found.clear_until, time) << i;
        tested += found.clear_until > 0.1;
    }
    EXPECT_GT(tested, 20u);
}

TEST_F(RobotEdges, ContactAtTheStartAndTheEndCounts)
{
    World world;
    world.bodies().add(
        {.model = world.models().add(Box{{0.1, 0.1, 0.1}}), .pose = Isometry3d(Translation3d(0, 0, 1.1))});
    const Robot robot(world, description);
    const std::vector<double> up{0, 0, 0.05}, aside{0, 1.5, 0.05};
    RobotEdgeFinding found;
    robot.check_edges(world, up, aside, {&found, 1});
    EXPECT_EQ(found.verdict, Verdict::colliding);
    EXPECT_EQ(found.clear_until, 0);
    EXPECT_EQ(found.contact_by, 0);
    robot.check_edges(world, aside, up, {&found, 1});
    EXPECT_EQ(found.verdict, Verdict::colliding);
    EXPECT_GT(found.clear_until, 0.5);
    EXPECT_LE(found.contact_by, 1);
    robot.check_edges(world, up, up, {&found, 1}); // rest
    EXPECT_EQ(found.contact_by, 0);
    robot.check_edges(world, aside, aside, {&found, 1});
    EXPECT_EQ(found.verdict, Verdict::separate);
}

TEST_F(RobotEdges, BadInputIsRefused)
{
    World world;
    const Robot robot(world, description);
    RobotEdgeFinding found;
    const std::vector<double> good{0, 0, 0.05}, bad{0, std::nan(""), 0.05};
    EXPECT_THROW(robot.check_edges(world, good, std::vector<double>{0, 0}, {&found, 1}), Error);
    EXPECT_THROW(robot.check_edges(world, bad, good, {&found, 1}), Error);
    EXPECT_THROW(robot.check_edges(world, good, bad, {&found, 1}), Error);
    EXPECT_THROW(robot.check_edges(world, good, good, {&found, 1}, {.tolerance = 0}), Error);
}

/// All kinds of joints in one chain: no point of a ball moves farther than the bound, or leaves the rigid motion
/// between the ends by more.
TEST_F(RobotEdges, BoundsOfTravelHoldForAllKindsOfJoints)
{
    RobotDescription chain = description, arm = description;
    chain.joints[0].kind = JointKind::planar;   // base to upper
    chain.joints[1].kind = JointKind::floating; // upper to lower
    std::mt19937 random(9);
    const auto any = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
    double largest = 0, farthest = 0, most_bent = 0;
    int helices = 0;
    for (int trial = 0; trial < 4000; ++trial) {
        const Kinematics tree(trial % 2 ? chain : arm);
        const double step = std::pow(10.0, any(-3, 0.3));
        std::vector<double> from(tree.width()), to(tree.width());
        for (std::size_t i = 0; i < from.size(); ++i)
            from[i] = any(-1, 1), to[i] = from[i] + (trial % 5 == 0 && i > 0 ? 0 : step * any(-1, 1));
        if (trial % 2)
            for (auto* numbers : {&from, &to}) Eigen::Map<Eigen::Quaterniond>(numbers->data() + 6).normalize();
        using Poses = std::vector<Isometry3d>;
        const auto place = [&](double share) {
            std::vector<double> numbers(tree.width());
            Poses poses(6, Isometry3d::Identity());
            tree.between(from.data(), to.data(), share, numbers.data());
            tree.link_poses(numbers.data(), Isometry3d::Identity(), poses.data());
            return poses;
        };
        const Poses begin = place(0), middle = place(0.5), end = place(1);
        const CoverSphere ball{Vector3d(any(-1, 1), any(-1, 1), any(-1, 1)), any(0, 0.5)};
        const auto link = static_cast<std::uint32_t>(trial % 5), from_link = static_cast<std::uint32_t>(trial / 5 % 5);
        const auto seen = [&](const Poses& poses) { return Isometry3d(poses[from_link].inverse() * poses[link]); };
        const BallTravel bound = tree.travel(from.data(), to.data(), 0.5, middle.data(), ball, link, from_link);
        const RigidMotion rigid(seen(begin), seen(end), bound.helix ? MotionPath::screw : MotionPath::linear);
        const double off = bound.off(ball.centre.norm() + ball.radius);
        helices += bound.helix && bound.moved > 0;
        for (int k = 0; k < 6; ++k) {
            const double share = k < 2 ? k : any(0, 1);
            const Isometry3d there = seen(place(share)), guess = rigid.pose(share);
            for (int point = 0; point < 5; ++point) {
                const Vector3d x =
                    ball.centre + ball.radius * Vector3d(any(-1, 1), any(-1, 1), any(-1, 1)).normalized();
                const double moved = (there * x - seen(middle) * x).norm(), left = (there * x - guess * x).norm();
                const Vector3d chord = (1 - share) * (seen(begin) * x) + share * (seen(end) * x);
                const double bent = (there * x - chord).norm();
                ASSERT_LE(bent, bound.sagitta() * (1 + 1e-9) + 1e-13)
                    << "trial " << trial << ", link " << link << " from " << from_link;
                if (bound.bend > 0) most_bent = std::max(most_bent, bent / bound.sagitta());
                ASSERT_LE(moved, bound.moved * (1 + 1e-9) + 1e-14)
                    << "trial " << trial << ", link " << link << " from " << from_link;
                ASSERT_LE(left, off * (1 + 1e-9) + 1e-13)
                    << "trial " << trial << ", link " << link << " from " << from_link;
                if (bound.moved > 0) largest = std::max(largest, moved / bound.moved);
                if (off > 0) farthest = std::max(farthest, left / off);
            }
        }
    }
    EXPECT_GT(largest, 0.8); // the bounds are no gross ones
    EXPECT_GT(farthest, 0.3);
    EXPECT_GT(most_bent, 0.7);
    EXPECT_GT(helices, 100);
}

} // namespace
} // namespace oncollide::robot_test
