#include <gtest/gtest.h>

#include <oncollide/robots/cover.hpp>
#include <oncollide/robots/robot.hpp>
#include <oncollide/samples/generators.hpp>

namespace oncollide::cover_test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

bool in(const CoverSphere& sphere, const Vector3d& point)
{
    return (point - sphere.centre).norm() <= sphere.radius;
}

TEST(Cover, SpheresContainEveryTriangle)
{
    const Mesh mesh = make_torus_knot_mesh(2, 3, 0.3, 0.12, 0.05, 2000);
    for (const std::size_t count : {1, 2, 7, 16}) {
        const std::vector<CoverSphere> spheres = cover_triangles(mesh, count);
        EXPECT_EQ(spheres.size(), count);
        for (const Triangle& t : mesh.triangles)
            EXPECT_TRUE(std::ranges::any_of(spheres, [&](const CoverSphere& sphere) {
                return std::ranges::all_of(t, [&](std::uint32_t v) { return in(sphere, mesh.vertices[v]); });
            }));
    }
}

TEST(Cover, SpheresContainTheSolidBox)
{
    Aabb box;
    box.add({-1, 2, 3}), box.add({1, 2.5, 13});
    const std::vector<CoverSphere> spheres = cover_box(box, 16);
    EXPECT_GT(spheres.size(), 2u);
    for (int x = 0; x <= 8; ++x)
        for (int y = 0; y <= 4; ++y)
            for (int z = 0; z <= 400; ++z) {
                const Vector3d point(-1 + 0.25 * x, 2 + 0.125 * y, 3 + 0.025 * z);
                EXPECT_TRUE(std::ranges::any_of(spheres, [&](const CoverSphere& s) { return in(s, point); }));
            }
}

/// Two rods that slide towards each other until their ends touch at a corner, in many directions: bounding spheres
/// must not rule the pair out, also where the corner is on the border of its sphere.
TEST(Cover, NoContactOfCornersIsRuledOut)
{
    for (int turn = 0; turn < 60; ++turn) {
        RobotDescription robot;
        robot.name = "rods";
        const auto rod = std::make_shared<const Geometry>(Geometry{"rod", Box{{0.05, 0.07, 0.5}}, {}});
        Isometry3d at = Isometry3d::Identity();
        at.linear() =
            Eigen::AngleAxisd(0.1 * turn, Vector3d(1, 0.3 * (turn % 5), 0.2 * turn).normalized()).toRotationMatrix();
        robot.links = {{"fixed", {{rod, Isometry3d::Identity()}}}, {"moving", {{rod, at}}}};
        RobotJoint joint;
        joint.name = "slide", joint.kind = JointKind::prismatic, joint.child = 1;
        joint.axis = Vector3d(std::sin(1.3 * turn), std::cos(1.3 * turn), 2 * std::sin(0.7 * turn)).normalized();
        robot.joints = {joint};
        World world;
        const Robot made(world, robot);
        const ModelId model = world.models().add(Box{{0.05, 0.07, 0.5}});
        double apart = 3, meeting = 0; // by halves, without the robot
        const auto meets = [&](double q) {
            Isometry3d pose = at;
            pose.translation() = q * joint.axis;
            return world.pairs().decide(PlacedModel{model, Isometry3d::Identity()}, PlacedModel{model, pose}).verdict ==
                   Verdict::colliding;
        };
        ASSERT_TRUE(meets(meeting));
        while (apart - meeting > 1e-9) (meets((apart + meeting) / 2) ? meeting : apart) = (apart + meeting) / 2;
        std::vector<RobotFinding> found(2);
        made.check(world, std::vector<double>{meeting - 1e-9, apart + 1e-9}, found);
        EXPECT_EQ(found[0].verdict, Verdict::colliding) << turn;
        EXPECT_EQ(found[1].verdict, Verdict::separate) << turn;
    }
}

/// Their bounding spheres are the spheres, so any that is too small loses the contact.
TEST(Cover, NoContactOfSpheresIsRuledOut)
{
    RobotDescription robot;
    robot.name = "balls";
    const auto ball = [](double radius) {
        return LinkGeometry{std::make_shared<const Geometry>(Geometry{"ball", Sphere{radius}, {}})};
    };
    robot.links = {{"fixed", {ball(0.1)}}, {"moving", {ball(0.05)}}};
    RobotJoint joint;
    joint.name = "slide", joint.kind = JointKind::prismatic, joint.child = 1;
    joint.axis = Vector3d(1, 2, 3).normalized();
    robot.joints = {joint};
    for (const double clearance : {0.0, 0.01}) {
        World world({.clearance = clearance});
        const Robot made(world, robot, Isometry3d(Eigen::Translation3d(3, 4, 5)));
        const double reach = 0.15 + clearance;
        std::vector<RobotFinding> found(4);
        made.check(world, std::vector<double>{reach - 1e-9, reach + 1e-9, -reach + 1e-9, -reach - 1e-9}, found);
        EXPECT_NE(found[0].verdict, Verdict::separate);
        EXPECT_EQ(found[1].verdict, Verdict::separate);
        EXPECT_NE(found[2].verdict, Verdict::separate);
        EXPECT_EQ(found[3].verdict, Verdict::separate);
    }
}

/// Poses may stretch or shrink by as much as a World accepts. Then needles whose tips meet can be farther apart than
/// their spheres.
TEST(Cover, NoContactIsRuledOutWherePosesAreNotQuiteRigid)
{
    const auto needle = [](double half) {
        return std::make_shared<const Geometry>(
            Geometry{"needle", make_mesh("needle", {{-half, 0, 0}, {half, 0, 0}, {0, 1e-9, 0}}, {{0, 1, 2}}), {}});
    };
    Isometry3d turned = Isometry3d::Identity(), shrunk = turned;
    turned.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
    shrunk.linear() *= 1 - 4e-7;
    RobotDescription robot;
    robot.name = "needles";
    robot.links = {{"fixed", {{needle(1), Isometry3d::Identity()}}}, {"moving", {{needle(0.01), turned}}}};
    RobotJoint joint;
    joint.name = "slide", joint.kind = JointKind::prismatic, joint.child = 1;
    robot.joints = {joint};
    World world;
    const Robot made(world, robot, shrunk);
    const ModelId fixed = world.models().add(robot.links[0].collision[0].geometry),
                  moving = world.models().add(robot.links[1].collision[0].geometry);
    std::vector<double> numbers;
    for (int i = -10; i <= 10; ++i) numbers.push_back(1.01 + 1e-7 * i);
    std::vector<RobotFinding> found(numbers.size());
    made.check(world, numbers, found);
    std::size_t contacts = 0;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        std::vector<Isometry3d> links(2);
        made.link_poses({&numbers[i], 1}, links);
        const Finding alone =
            world.pairs().decide(PlacedModel{fixed, links[0]}, PlacedModel{moving, links[1] * turned});
        EXPECT_EQ(found[i].verdict, alone.verdict) << numbers[i];
        contacts += alone.verdict == Verdict::colliding;
    }
    EXPECT_GT(contacts, 16u);
    EXPECT_LT(contacts, numbers.size());
}

/// The same with the environment, and with links of so many parts that a sphere around them is tested first.
TEST(Cover, NoContactOfALinkOfManyPartsIsRuledOut)
{
    RobotDescription robot;
    robot.name = "beads";
    RobotLink beads{"beads", {}};
    for (int i = 0; i < 6; ++i) {
        Isometry3d at = Isometry3d::Identity();
        at.translation() << 0.1 * i, 0.02 * i * i, 0;
        beads.collision.push_back({std::make_shared<const Geometry>(Geometry{"bead", Sphere{0.05}, {}}), at});
    }
    robot.links = {{"root", {}}, beads};
    RobotJoint joint;
    joint.name = "slide", joint.kind = JointKind::prismatic, joint.child = 1;
    robot.joints = {joint};
    World world;
    const Robot made(world, robot);
    // The last bead's centre is at x = 0.5 + q, y = 0.5; the first one's at x = q, y = 0.
    world.bodies().add(
        {.model = world.models().add(Box{{0.1, 0.01, 0.1}}), .pose = Isometry3d(Eigen::Translation3d(1, 0.5, 0))});
    world.bodies().add(
        {.model = world.models().add(Box{{0.1, 0.01, 0.1}}), .pose = Isometry3d(Eigen::Translation3d(-1, 0, 0))});
    std::vector<RobotFinding> found(4);
    made.check(world, std::vector<double>{0.35 + 1e-9, 0.35 - 1e-9, -0.85 + 1e-9, -0.85 - 1e-9}, found);
    EXPECT_EQ(found[0].verdict, Verdict::colliding);
    EXPECT_EQ(found[1].verdict, Verdict::separate);
    EXPECT_EQ(found[2].verdict, Verdict::separate);
    EXPECT_EQ(found[3].verdict, Verdict::colliding);
}

} // namespace
} // namespace oncollide::cover_test
