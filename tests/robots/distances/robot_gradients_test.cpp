// Gradients of Robot::distances() against differences of distances, and where they are unique.
#include <gtest/gtest.h>

#include <map>
#include <numbers>

#include "robots/distances/pair_key.hpp"
#include "robots/long_arm.hpp"
#include "robots/small_robot.hpp"

namespace oncollide::robot_gradients_test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using test::add_bodies, test::add_posts, test::Key, test::key_of, test::long_arm, test::numbers_of,
    test::random_numbers, test::SmallRobot;

/// Compares gradients where they are unique with central differences of the same pair's distance.
/// @return how many
std::size_t compare_gradients(const World& world, const Robot& robot, std::span<const double> numbers, double error)
{
    constexpr double h = 1e-5;
    const std::size_t width = robot.width();
    RobotDistances found, there;
    robot.distances(world, numbers, found, {.every_pair = true});
    std::size_t compared = 0;
    for (std::size_t i = 0; i + 1 < found.offsets.size(); ++i) {
        std::vector<std::map<Key, RobotDistance>> moved; // four for each number
        for (std::size_t k = 0; k < width; ++k)
            for (const double by : {-2 * h, -h, h, 2 * h}) {
                std::vector<double> at(numbers.begin() + static_cast<std::ptrdiff_t>(i * width),
                                       numbers.begin() + static_cast<std::ptrdiff_t>((i + 1) * width));
                at[k] += by;
                robot.distances(world, at, there, {.every_pair = true, .gradients = true});
                moved.emplace_back();
                for (const RobotDistance& d : there.pairs) moved.back()[key_of(d)] = d;
            }
        for (std::size_t p = found.offsets[i]; p < found.offsets[i + 1]; ++p) {
            const RobotDistance& d = found.pairs[p];
            if (!d.unique || d.lower < 0.01) continue;
            for (std::size_t k = 0; k < width; ++k) {
                const auto at = [&](std::size_t n) { return moved[4 * k + n].at(key_of(d)); };
                // Where the nearest features change within the step, the second derivative jumps.
                const double wide = (at(3).upper - at(0).upper) / (4 * h), slim = (at(2).upper - at(1).upper) / (2 * h);
                if (std::abs(wide - slim) > 1e-7) continue;
                EXPECT_NEAR(found.gradients[p * width + k], slim, error * std::max(1.0, std::abs(slim)))
                    << "configuration " << i << ", links " << d.link << " " << d.other << ", number " << k
                    << ", distance " << d.upper;
                ++compared;
            }
        }
    }
    return compared;
}

TEST(RobotDistances, GradientsAreDifferencesOfDistances)
{
    World world;
    add_bodies(world, 14, 2, 3);
    const Robot robot(world, long_arm(), random_pose(3, 0.2));
    EXPECT_GT(compare_gradients(world, robot, numbers_of(robot, 6, 1), 1e-6), 300u);
    SmallRobot files; // with a joint that mimics another
    World posts;
    add_posts(posts);
    const Robot small(posts,
                      load_robot(files.urdf, {.srdf = files.srdf, .packages = {{"robot", files.folder().path()}}}));
    EXPECT_GT(compare_gradients(posts, small, random_numbers(30), 1e-6), 500u);
}

RobotDescription with_joint(JointKind kind)
{
    RobotDescription robot;
    robot.name = "two";
    const auto geometry = [](GeometryData data) {
        return std::make_shared<const Geometry>(Geometry{"part", std::move(data), {}});
    };
    robot.links = {{"root", {}},
                   {"arm", {{geometry(Shape(Box{{0.1, 0.2, 0.3}})), random_pose(4, 0.3)}}},
                   {"hand", {{geometry(make_torus_mesh(0.2, 0.05, 200)), random_pose(5, 0.2)}}}};
    RobotJoint first, second;
    first.name = "first", first.kind = kind, first.parent = 0, first.child = 1;
    first.origin = random_pose(8, 0.5), first.axis = Vector3d(1, 2, 2) / 3;
    second.name = "second", second.kind = JointKind::continuous, second.parent = 1, second.child = 2;
    second.origin = random_pose(9, 0.5), second.axis = Vector3d(2, -1, 2) / 3;
    robot.joints = {first, second};
    robot.excluded = {{1, 2}};
    return robot;
}

TEST(RobotDistances, GradientsOfPlanarAndFloatingJointsAreDifferences)
{
    for (const JointKind kind : {JointKind::planar, JointKind::floating}) {
        World world;
        add_bodies(world, 6, 2.5, 4);
        const Robot robot(world, with_joint(kind), random_pose(2, 0.2));
        std::vector<double> numbers(robot.width());
        std::mt19937 random(3);
        for (double& number : numbers) number = std::uniform_real_distribution(-0.5, 0.5)(random);
        if (kind == JointKind::floating) {
            const Eigen::Quaterniond turn(random_pose(6, 1).linear());
            Eigen::Map<Eigen::Quaterniond> given(&numbers[3]);
            given = turn;
        }
        if (kind == JointKind::planar) {
            EXPECT_GT(compare_gradients(world, robot, numbers, 1e-6), 20u);
        }
        // The four numbers of a quaternion: along its tangents, because only unit ones are allowed.
        RobotDistances found, there[2];
        robot.distances(world, numbers, found, {.every_pair = true});
        std::vector<double> rows(6 * robot.width());
        const Vector3d point(0.1, 0.2, 0.3);
        robot.jacobian(numbers, 2, point, rows);
        std::size_t compared = 0;
        for (int trial = 0; trial < 5; ++trial) {
            Eigen::VectorXd way(robot.width());
            for (double& w : way) w = std::uniform_real_distribution(-1.0, 1.0)(random);
            const auto size = static_cast<Eigen::Index>(robot.width());
            const Eigen::VectorXd start = Eigen::Map<const Eigen::VectorXd>(numbers.data(), size);
            std::array<Isometry3d, 2> pose_there;
            for (int side = 0; side < 2; ++side) {
                Eigen::VectorXd at = start + (side ? 1e-5 : -1e-5) * way;
                if (kind == JointKind::floating) at.segment<4>(3).normalize();
                robot.distances(world, std::span<const double>(at.data(), robot.width()), there[side],
                                {.every_pair = true});
                std::vector<Isometry3d> poses(3);
                robot.link_poses(std::span<const double>(at.data(), robot.width()), poses);
                pose_there[static_cast<std::size_t>(side)] = poses[2];
            }
            if (kind == JointKind::floating)
                way.segment<4>(3) -= way.segment<4>(3).dot(start.segment<4>(3)) * start.segment<4>(3);
            for (std::size_t p = 0; p < found.pairs.size(); ++p) {
                const RobotDistance& d = found.pairs[p];
                if (!d.unique || d.lower < 0.01) continue;
                const auto upper = [&](const RobotDistances& of) {
                    return std::ranges::find(of.pairs, key_of(d), key_of)->upper;
                };
                const double slope =
                    Eigen::Map<const Eigen::VectorXd>(&found.gradients[p * robot.width()], size).dot(way);
                EXPECT_NEAR(slope, (upper(there[1]) - upper(there[0])) / 2e-5, 2e-6) << name_of(kind);
                ++compared;
            }
            const Eigen::Map<const Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor>> jacobian(rows.data(), 6,
                                                                                                       size);
            const Eigen::VectorXd twist = jacobian * way;
            EXPECT_LT((twist.head<3>() - (pose_there[1] * point - pose_there[0] * point) / 2e-5).norm(), 1e-8);
            const Eigen::AngleAxisd turn(pose_there[1].linear() * pose_there[0].linear().transpose());
            EXPECT_LT((twist.tail<3>() - turn.angle() * turn.axis() / 2e-5).norm(), 1e-8);
        }
        EXPECT_GT(compared, 10u);
    }
}

/// Faces and edges that are parallel have many nearest points.
TEST(RobotDistances, SayWhereTheirGradientIsNotUnique)
{
    const auto robot_of = [](GeometryData data) {
        RobotDescription robot = with_joint(JointKind::continuous);
        robot.links.pop_back(), robot.joints.pop_back(), robot.excluded.clear();
        robot.joints[0].origin.setIdentity();
        robot.links[1].collision = {{std::make_shared<const Geometry>(Geometry{"part", std::move(data), {}}), {}}};
        robot.links[1].collision[0].pose.setIdentity();
        return robot;
    };
    const auto unique = [&](GeometryData part, GeometryData other, const Isometry3d& pose) {
        World world;
        world.bodies().add({.model = world.models().add(std::move(other)), .pose = pose, .is_static = true});
        const Robot robot(world, robot_of(std::move(part)));
        RobotDistances found;
        const double zero = 0;
        robot.distances(world, {&zero, 1}, found);
        return found.pairs.at(0).unique;
    };
    const auto above = [](double turn, const Vector3d& axis) {
        Isometry3d pose(Eigen::AngleAxisd(turn, axis.normalized()));
        pose.translation() = Vector3d(0.3, 0.2, 3);
        return pose;
    };
    const Vector3d x = Vector3d::UnitX(), any(1, 2, 3);
    const Shape box = Box{{0.5, 0.6, 0.7}}, ball = Sphere{0.4}, pill = Capsule{0.3, 1};
    const Mesh crate = make_box_mesh({0.5, 0.6, 0.7});
    EXPECT_FALSE(unique(box, box, above(0, x)));
    EXPECT_FALSE(unique(crate, crate, above(0, x)));
    EXPECT_FALSE(unique(crate, box, above(0.3, x))); // an edge over a face
    EXPECT_TRUE(unique(box, box, above(0.7, any)));
    EXPECT_TRUE(unique(crate, crate, above(0.7, any)));
    EXPECT_TRUE(unique(ball, box, above(0, x)));
    EXPECT_TRUE(unique(ball, ball, above(0, x)));
    EXPECT_FALSE(unique(pill, box, above(std::numbers::pi / 2, x)) &&
                 unique(box, pill, above(std::numbers::pi / 2, x)));
    EXPECT_TRUE(unique(pill, pill, above(1, x)));
    Isometry3d below = Isometry3d::Identity();
    below.translation().z() = -3;
    EXPECT_FALSE(unique(box, Shape(HalfSpace{}), below));
    EXPECT_TRUE(unique(ball, Shape(HalfSpace{}), below));
}

} // namespace
} // namespace oncollide::robot_gradients_test
