// Descriptions made in code are refused where files are.
#include <functional>

#include <gtest/gtest.h>

#include <oncollide/robots/robot.hpp>
#include <oncollide/samples/generators.hpp>

namespace oncollide::description_fault_test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();

/// A base, an arm that turns, a hand that turns with it, and a slide.
RobotDescription arm()
{
    const auto box = std::make_shared<const Geometry>(Geometry{"box", Shape(Box{{0.1, 0.1, 0.1}}), {}});
    RobotDescription robot;
    robot.name = "arm";
    for (const char* name : {"base", "upper", "hand", "tip"})
        robot.links.push_back({name, {{box, Eigen::Isometry3d::Identity()}}});
    for (std::uint32_t i = 0; i < 3; ++i) {
        RobotJoint& joint = robot.joints.emplace_back();
        joint.name = std::vector{"turn", "follow", "slide"}[i];
        joint.kind = i < 2 ? JointKind::revolute : JointKind::prismatic;
        joint.parent = i, joint.child = i + 1, joint.lower = -1, joint.upper = 1;
        joint.origin.translation().x() = 0.5;
    }
    robot.joints[1].mimics = 0;
    robot.excluded = {{0, 1}, {1, 2}, {2, 3}};
    robot.groups = {{"all", {0, 1, 2, 3}, {0, 1, 2}}};
    robot.states = {{"bent", "all", {{0, {0.5}}, {2, {0.25}}}}};
    return robot;
}

std::string error_of(const RobotDescription& robot, World& world)
{
    try {
        Robot made(world, robot);
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::bad_data) << error.what();
        return error.what();
    }
    return "no error";
}

struct Fault {
    const char* name;
    std::function<void(RobotDescription&)> plant;
    const char* message;
};

class DescriptionFault : public ::testing::TestWithParam<Fault> {};

TEST_P(DescriptionFault, IsAnErrorThatNamesTheLinkOrTheJoint)
{
    RobotDescription robot = arm();
    GetParam().plant(robot);
    World world;
    const std::string error = error_of(robot, world);
    EXPECT_NE(error.find("robot 'arm'"), error.npos) << error;
    EXPECT_NE(error.find(GetParam().message), error.npos) << error;
    EXPECT_EQ(world.models().size(), 0u) << "nothing has changed";
}

RobotJoint& follow(RobotDescription& robot)
{
    return robot.joints[1];
}
RobotJoint& slide(RobotDescription& robot)
{
    return robot.joints[2];
}

INSTANTIATE_TEST_SUITE_P(
    InCode, DescriptionFault,
    ::testing::Values(
        Fault{"PlanarMimic", [](auto& r) { follow(r).kind = JointKind::planar; },
              "joint 'follow': only revolute, continuous and prismatic joints can mimic each other"},
        Fault{"FloatingMimic", [](auto& r) { follow(r).kind = JointKind::floating; }, "can mimic each other"},
        Fault{"FixedMimic", [](auto& r) { follow(r).kind = JointKind::fixed; }, "can mimic each other"},
        Fault{"MimicOfPlanar", [](auto& r) { r.joints[0].kind = JointKind::planar; }, "can mimic each other"},
        Fault{"MimicOfItself", [](auto& r) { follow(r).mimics = 1; }, "joint 'follow': mimics itself"},
        Fault{"MimicOfAMimic", [](auto& r) { slide(r).mimics = 1; },
              "joint 'slide': mimics joint 'follow', which has no value of its own"},
        Fault{"MimicOfNoJoint", [](auto& r) { follow(r).mimics = 3; }, "mimics joint 3 does not exist"},
        Fault{"NegativeMimic", [](auto& r) { follow(r).mimics = -2; }, "mimics joint -2 does not exist"},
        Fault{"Multiplier", [](auto& r) { follow(r).multiplier = inf; }, "its multiplier is inf"},
        Fault{"Offset", [](auto& r) { follow(r).offset = nan; }, "its offset is nan"},
        Fault{"Kind", [](auto& r) { slide(r).kind = static_cast<JointKind>(17); }, "there is no kind 17 of joints"},
        Fault{"Parent", [](auto& r) { slide(r).parent = 4; }, "joint 'slide': link 4 does not exist"},
        Fault{"Child", [](auto& r) { slide(r).child = ~0u; }, "link 4294967295 does not exist"},
        Fault{"OneLink", [](auto& r) { slide(r).child = 2; }, "joint 'slide': connects a link with itself"},
        Fault{"Origin", [](auto& r) { slide(r).origin.translation().x() = nan; },
              "joint 'slide': the pose is not finite"},
        Fault{"LongAxis", [](auto& r) { slide(r).axis *= 2; }, "joint 'slide': its axis (2, 0, 0) is not of length 1"},
        Fault{"NoAxis", [](auto& r) { slide(r).axis.setZero(); }, "its axis (0, 0, 0)"},
        Fault{"NanAxis", [](auto& r) { slide(r).axis.y() = nan; }, "its axis (1, nan, 0)"},
        Fault{"LimitsReversed", [](auto& r) { slide(r).lower = 2; }, "joint 'slide': its limits are 2 to 1"},
        Fault{"NanLimit", [](auto& r) { slide(r).upper = nan; }, "its limits are -1 to nan"},
        Fault{"EndlessLimit", [](auto& r) { slide(r).lower = slide(r).upper = inf; }, "exclude everything up to 1e9"},
        Fault{"Loop", [](auto& r) { r.joints.push_back(slide(r)), r.joints[3].name = "back", r.joints[3].child = 0; },
              "link 'base': the joints above it form a loop"},
        Fault{"Diamond",
              [](auto& r) { r.joints.push_back(slide(r)), r.joints[3].name = "again", r.joints[3].parent = 0; },
              "joint 'again': link 'tip' is already the child of joint 'slide'"},
        Fault{"TwoRoots", [](auto& r) { r.joints.pop_back(), r.states.clear(), r.groups.clear(); },
              "link 'tip': is a second root, beside 'base'"},
        Fault{"NoLink", [](auto& r) { r = {}, r.name = "arm"; }, "has no link"},
        Fault{"NameOfTwoLinks", [](auto& r) { r.links[3].name = "hand"; }, "link 'hand': there are two links"},
        Fault{"NoName", [](auto& r) { r.joints[2].name.clear(); }, "joint 2: has no name"},
        Fault{"NoGeometry", [](auto& r) { r.links[1].collision[0].geometry.reset(); },
              "link 'upper': there is no geometry"},
        Fault{"BadGeometry",
              [](auto& r) {
                  Mesh mesh = make_box_mesh({1, 1, 1});
                  mesh.triangles[3][1] = 8;
                  r.links[1].collision.push_back(r.links[1].collision[0]);
                  r.links[1].collision[1].geometry = std::make_shared<const Geometry>(Geometry{"b", mesh, {}});
              },
              "link 'upper': collision 1: geometry: triangle 3 uses vertex 8"},
        Fault{"NoHeight",
              [](auto& r) {
                  r.links[1].collision[0].geometry =
                      std::make_shared<const Geometry>(Geometry{"b", Shape(Cylinder{1, 0}), {}});
              },
              "link 'upper': geometry: the length is 0"},
        Fault{"Excluded",
              [](auto& r) {
                  r.excluded.push_back({1, 9});
              },
              "excluded pair 3: link 9 does not exist"},
        Fault{"ExcludedFromItself", [](auto& r) { r.excluded = {{1, 1}}; }, "names link 'upper' twice"},
        Fault{"LinkOfGroup", [](auto& r) { r.groups[0].links.push_back(4); }, "group 'all': link 4 does not exist"},
        Fault{"JointOfGroup", [](auto& r) { r.groups[0].joints = {7}; }, "group 'all': joint 7 does not exist"},
        Fault{"TwoGroups", [](auto& r) { r.groups.push_back(r.groups[0]); }, "there are two groups of this name"},
        Fault{"StateOfNoGroup", [](auto& r) { r.states[0].group = "al"; }, "state 'bent': there is no group 'al'"},
        Fault{"JointOfState", [](auto& r) { r.states[0].values[0].joint = 3; }, "state 'bent': joint 3 does not exist"},
        Fault{"StateOfAMimic", [](auto& r) { r.states[0].values[0].joint = 1; },
              "state 'bent': joint 'follow' takes 0 numbers, not 1"},
        Fault{"NumbersOfState", [](auto& r) { r.states[0].values[1].numbers = {0, 0}; },
              "joint 'slide' takes 1 numbers, not 2"},
        Fault{"NanInState", [](auto& r) { r.states[0].values[1].numbers = {nan}; },
              "joint 'slide': nan is not a number"}),
    [](const auto& each) { return each.param.name; });

TEST(Description, ExcludedPairsCountInAnyOrder)
{
    RobotDescription robot = arm();
    World world;
    const Robot sorted(world, robot);
    robot.excluded = {{3, 2}, {1, 0}, {2, 1}};
    const Robot made(world, robot);
    EXPECT_EQ(made.description().excluded, sorted.description().excluded);
}

TEST(Description, AnAxisThatIsNearlyOfLength1GivesARigidPose)
{
    RobotDescription robot = arm();
    robot.joints[0].axis *= 1 + 9e-7;
    World world;
    const Robot made(world, robot);
    std::vector<Eigen::Isometry3d> poses(4);
    made.link_poses(std::vector{1.0, 0.0}, poses);
    const Eigen::Matrix3d turn = poses[1].linear();
    EXPECT_LT((turn.transpose() * turn - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(Description, AttachRefusesLinksThatDoNotExist)
{
    World world;
    Robot robot(world, arm());
    const ModelId ball = world.models().add(Sphere{0.1});
    const auto attach = [&](std::uint32_t link, ModelId model, std::uint32_t touching) {
        robot.attach(world, link, model, Eigen::Isometry3d::Identity(), {&touching, 1});
    };
    EXPECT_THROW(attach(4, ball, 0), Error);
    EXPECT_THROW(attach(3, ball, 4), Error);
    EXPECT_THROW(attach(3, {}, 0), Error);
    World other;
    EXPECT_THROW(attach(3, other.models().add(Sphere{0.1}), 0), Error);
    robot.add_bodies(world);
    EXPECT_EQ(robot.bodies().size(), 4u) << "no attempt has left an object";
}

/// The World gives the slot of a removed body to another one, which is in the robot's way.
TEST(Description, ABodyInTheSlotOfARemovedOneIsNotTheRobots)
{
    World world;
    Robot robot(world, arm());
    robot.add_bodies(world);
    world.bodies().remove(robot.bodies()[3]);
    const BodyId way = world.bodies().add({.model = world.models().add(Sphere{0.3})});
    ASSERT_EQ(way.slot, robot.bodies()[3].slot);
    std::vector<RobotFinding> found(1);
    robot.check(world, robot.neutral(), found);
    EXPECT_EQ(found[0].verdict, Verdict::colliding);
    EXPECT_EQ(found[0].body, way);
    std::vector<RobotEdgeFinding> edges(1);
    robot.check_edges(world, robot.neutral(), std::vector{0.5, 0.0}, edges);
    EXPECT_EQ(edges[0].verdict, Verdict::colliding);
    robot.remove_bodies(world);
    EXPECT_EQ(world.bodies().size(), 1u) << "the sphere";
}

TEST(Description, ALinkOrAnObjectThatIsOpenIsRefusedInSolidMode)
{
    RobotDescription robot = arm();
    Mesh open = make_box_mesh({0.1, 0.1, 0.1});
    open.triangles.pop_back();
    World world({.mode = Mode::solid});
    Robot closed(world, robot);
    const std::size_t models = world.models().size();
    robot.links[2].collision[0].geometry = std::make_shared<const Geometry>(Geometry{"holed", open, {}});
    const std::string error = error_of(robot, world);
    EXPECT_NE(error.find("robot 'arm': link 'hand': holed: the mesh is not closed"), error.npos) << error;
    EXPECT_EQ(world.models().size(), models);
    EXPECT_THROW(closed.attach(world, 3, world.models().add(open), Eigen::Isometry3d::Identity()), Error);
    World taken({.mode = Mode::solid, .open_as_surface = true});
    EXPECT_EQ(error_of(robot, taken), "no error");
}

} // namespace
} // namespace oncollide::description_fault_test
