#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include <fmt/format.h>

#include "temporary_folder.hpp"
#include <oncollide/robots/robot.hpp>

namespace oncollide::mjcf_file_test {
namespace {

using Eigen::Vector3d;

/// An arm on the floor, with a ball that lies about.
const std::string arm = R"(<mujoco model="arm">
  <compiler meshdir="parts"/>
  <include file="settings.xml"/>
  <asset><mesh file="wedge.obj" class="small"/><mesh name="absent" file="no.stl"/></asset>
  <worldbody>
    <geom type="plane" size="0 0 1" name="floor"/>
    <body name="base" pos="0 0 0.2">
      <geom type="box" size="0.1 0.1 0.2"/><geom class="seen" type="mesh" mesh="absent"/>
      <body name="upper" pos="0 0 0.25" childclass="pipe">
        <joint name="shoulder" axis="0 0 2"/>
        <geom fromto="0 0 0 0 0 0.5" size="0.04"/>
        <frame pos="0 0 0.5" euler="0 0 90"><body name="lower">
          <joint name="elbow" axis="0 1 0" range="-90 120" ref="30"/>
          <geom type="mesh" mesh="wedge"/><geom name="pad" type="sphere" size="0.02" pos="0 0 0.4" contype="2"/>
          <body name="rail" pos="0 0 0.6"><joint name="slide" type="slide" pos="9 9 9" range="0 0.1"/>
            <geom size="0.03"/></body></body></frame>
      </body>
    </body>
    <body name="ball" pos="1 0 0.1"><freejoint/><geom type="sphere" size="0.1"/></body>
  </worldbody>
  <contact><exclude body1="ball" body2="rail"/><pair geom1="pad" geom2="floor"/></contact>
  <keyframe><key name="home" qpos="1 0.5 0.05 1 2 3 2 0 0 0"/></keyframe>
  <actuator><motor joint="elbow"/></actuator>
</mujoco>
)";

class MjcfFile : public ::testing::Test {
protected:
    MjcfFile()
    {
        std::filesystem::create_directories(folder / "parts");
        folder.write("parts/wedge.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
        folder.write("settings.xml",
                     "<mujocoinclude>\n<default>\n<default class='pipe'>\n<geom type='capsule' size='0.02 0.1'/>"
                     "</default><default class='seen'><geom contype='0' conaffinity='0'/></default>"
                     "<default class='small'><mesh scale='0.1 0.1 0.4'/></default></default></mujocoinclude>");
    }
    std::filesystem::path changed(const std::string& from, const std::string& to) const
    {
        std::string text = arm;
        const std::size_t at = text.find(from);
        if (at == text.npos) std::abort();
        return folder.write("changed.xml", text.replace(at, from.size(), to));
    }
    static std::string error_of(const std::filesystem::path& path)
    {
        try {
            load_robot(path);
        } catch (const Error& error) {
            EXPECT_EQ(error.kind(), ErrorKind::bad_data) << error.what();
            return error.what();
        }
        return "no error";
    }
    static std::uint32_t link(const RobotDescription& robot, const std::string& name)
    {
        const auto found = std::ranges::find(robot.links, name, &RobotLink::name);
        EXPECT_NE(found, robot.links.end()) << name;
        return static_cast<std::uint32_t>(found - robot.links.begin());
    }
    static bool tests(const RobotDescription& robot, const std::string& a, const std::string& b)
    {
        return !std::ranges::count(
            robot.excluded, std::pair<std::uint32_t, std::uint32_t>(std::minmax(link(robot, a), link(robot, b))));
    }
    test::TemporaryFolder folder;
};

TEST_F(MjcfFile, HasTheTreeTheShapesAndTheLimitsOfTheFile)
{
    const RobotDescription robot = load_robot(folder.write("arm.xml", arm));
    EXPECT_EQ(robot.name, "arm");
    std::vector<std::string> links, joints;
    for (const RobotLink& each : robot.links) links.push_back(each.name);
    for (const RobotJoint& each : robot.joints) joints.push_back(each.name);
    EXPECT_EQ(links, (std::vector<std::string>{"world", "base", "upper", "lower", "lower/pad", "rail", "ball"}));
    EXPECT_EQ(joints,
              (std::vector<std::string>{"base/fixed", "shoulder", "elbow", "lower/pad/fixed", "slide", "ball/joint"}));
    EXPECT_EQ(robot.joints[1].kind, JointKind::continuous);
    EXPECT_EQ(robot.joints[1].axis, Vector3d::UnitZ());
    EXPECT_EQ(robot.joints[2].kind, JointKind::revolute);
    EXPECT_NEAR(robot.joints[2].upper, 120 * std::numbers::pi / 180, 1e-12);
    EXPECT_EQ(robot.joints[4].kind, JointKind::prismatic);
    EXPECT_EQ(robot.joints[5].kind, JointKind::floating);
    EXPECT_TRUE(std::holds_alternative<HalfSpace>(std::get<Shape>(robot.links[0].collision.at(0).geometry->data)));
    ASSERT_EQ(robot.links[1].collision.size(), 1u); // geoms that are only seen are left out, with their meshes
    const auto& pipe = std::get<Capsule>(std::get<Shape>(robot.links[2].collision.at(0).geometry->data));
    EXPECT_EQ(pipe.radius, 0.04);
    EXPECT_NEAR(pipe.length, 0.5, 1e-15);
    const auto& wedge = std::get<Mesh>(robot.links[3].collision.at(0).geometry->data);
    EXPECT_TRUE(wedge.bounds.max.isApprox(Vector3d(0.1, 0.1, 0.4)));
    const auto& rail = std::get<Capsule>(std::get<Shape>(robot.links[5].collision.at(0).geometry->data));
    EXPECT_EQ(rail.radius, 0.03); // the length is of the class
    EXPECT_EQ(rail.length, 0.2);
}

TEST_F(MjcfFile, LeavesOutThePairsThatMujocoDoes)
{
    const RobotDescription robot = load_robot(folder.write("arm.xml", arm));
    EXPECT_FALSE(tests(robot, "world", "base"));  // both at rest
    EXPECT_TRUE(tests(robot, "world", "upper"));  // a child of the world's
    EXPECT_FALSE(tests(robot, "upper", "lower")); // parent and child
    EXPECT_TRUE(tests(robot, "upper", "rail"));
    EXPECT_TRUE(tests(robot, "ball", "lower"));
    EXPECT_FALSE(tests(robot, "ball", "rail"));      // <exclude>
    EXPECT_TRUE(tests(robot, "lower/pad", "world")); // <pair>
    EXPECT_TRUE(tests(robot, "lower/pad", "ball"));  // the pad's conaffinity is 1
    EXPECT_FALSE(tests(robot, "lower/pad", "lower"));
    const RobotDescription free = load_robot(changed("contype=\"2\"", "contype=\"2\" conaffinity=\"4\""));
    EXPECT_FALSE(tests(free, "lower/pad", "ball"));
    EXPECT_TRUE(tests(free, "lower/pad", "world"));
}

TEST_F(MjcfFile, ChecksARobotOnItsFloor)
{
    World world;
    Robot robot(world, load_robot(folder.write("arm.xml", arm)));
    const auto check = [&](double shoulder, double elbow, double height) {
        std::vector<double> numbers = robot.neutral();
        robot.apply_state("qpos0", "", numbers);
        numbers[0] = shoulder, numbers[1] = elbow, numbers[5] = height;
        RobotFinding found;
        robot.check(world, numbers, {&found, 1});
        return found.verdict;
    };
    EXPECT_EQ(check(0, 0.5, 0.11), Verdict::separate);
    EXPECT_EQ(check(0, 0.5, 0.09), Verdict::colliding); // the ball in the floor
    std::vector<double> from = robot.neutral();
    robot.apply_state("qpos0", "", from);
    from[5] = 0.3;
    std::vector<double> to = from;
    to[0] = 1, to[5] = 0.05;
    RobotEdgeFinding edge;
    robot.check_edges(world, from, to, {&edge, 1});
    EXPECT_EQ(edge.verdict, Verdict::colliding);
    EXPECT_NEAR(edge.clear_until, 0.8, 1e-3);
}

TEST_F(MjcfFile, KeyframesAndThePoseOfTheFileAreStates)
{
    const RobotDescription robot = load_robot(folder.write("arm.xml", arm));
    ASSERT_EQ(robot.states.size(), 2u);
    EXPECT_EQ(robot.states[0].name, "qpos0");
    EXPECT_NEAR(robot.states[0].values.at(1).numbers.at(0), std::numbers::pi / 6, 1e-15);
    EXPECT_EQ(robot.states[0].values.at(3).numbers, (std::vector<double>{1, 0, 0.1, 0, 0, 0, 1}));
    EXPECT_EQ(robot.states[1].name, "home");
    EXPECT_EQ(robot.states[1].values.at(2).numbers, std::vector<double>{0.05});
    EXPECT_EQ(robot.states[1].values.at(3).numbers, (std::vector<double>{1, 2, 3, 0, 0, 0, 1})); // w is last, unit
}

TEST_F(MjcfFile, ReadsIncludesOnceAndNamesTheirLines)
{
    folder.write("a.xml", "<mujoco>\n\n<include file='b.xml'/></mujoco>");
    folder.write("b.xml", "<mujoco>\n<include file='a.xml'/></mujoco>");
    const std::string cyclic = error_of(folder / "a.xml");
    EXPECT_NE(cyclic.find("b.xml: line 2: include: '"), cyclic.npos) << cyclic;
    EXPECT_NE(cyclic.find("is included twice"), cyclic.npos) << cyclic;
    folder.write("settings.xml", "<mujoco>\n<worldbody>\n<body>\n<geom type='blob'/></body></worldbody></mujoco>");
    const std::string inside = error_of(folder.write("arm.xml", "<mujoco><include file='settings.xml'/></mujoco>"));
    EXPECT_NE(inside.find("settings.xml: line 4: geom: unknown type 'blob'"), inside.npos) << inside;
}

struct MjcfFault {
    const char *name, *from, *to, *message;
};

class MjcfFaults : public MjcfFile, public ::testing::WithParamInterface<MjcfFault> {};

TEST_P(MjcfFaults, AreErrorsThatNameFileAndLine)
{
    const MjcfFault& fault = GetParam();
    const std::string error = error_of(changed(fault.from, fault.to));
    EXPECT_NE(error.find("changed.xml: line "), error.npos) << error;
    EXPECT_NE(error.find(fault.message), error.npos) << error;
}

INSTANTIATE_TEST_SUITE_P(
    Mjcf, MjcfFaults,
    ::testing::Values(
        MjcfFault{"Section", "<worldbody>", "<wordbody/><worldbody>",
                  "wordbody: is unknown in MJCF; did you mean 'worldbody'?"},
        MjcfFault{"Element", "<joint name=\"shoulder\"", "<jont/><joint name=\"shoulder\"",
                  "jont: is unknown in a body"},
        MjcfFault{"MissingMesh", "mesh=\"wedge\"", "mesh=\"absent\"", "mesh 'absent': "},
        MjcfFault{"NoMesh", "mesh=\"wedge\"", "mesh=\"wedg\"", "there is no mesh 'wedg'; did you mean 'wedge'?"},
        MjcfFault{"NoClass", "class=\"seen\"", "class=\"sen\"", "there is no class 'sen'; did you mean 'seen'?"},
        MjcfFault{"NaN", "pos=\"1 0 0.1\"", "pos=\"1 nan 0.1\"", "body 'ball': pos: 'nan' is not a finite number"},
        MjcfFault{"Size", "size=\"0.1 0.1 0.2\"", "size=\"0.1 0.1\"", "size has 2 numbers; a box has 3"},
        MjcfFault{"NegativeSize", "size=\"0.1\"/></body>", "size=\"-0.1\"/></body>", "it must be above 0"},
        MjcfFault{"Ball", "type=\"slide\"", "type=\"ball\"", "joint 'slide': a ball joint is not a kind of joint"},
        MjcfFault{"JointType", "type=\"slide\"", "type=\"slid\"", "unknown type 'slid'; did you mean 'slide'?"},
        MjcfFault{"Free", "<joint name=\"elbow\"", "<freejoint/><joint name=\"elbow\"",
                  "a free joint must be the only one"},
        MjcfFault{"Axis", "axis=\"0 0 2\"", "axis=\"0 0 0\"", "its axis has no direction"},
        MjcfFault{"Range", "range=\"-90 120\"", "range=\"90 -120\" limited=\"true\"", "its limits are "},
        MjcfFault{"TwoBodies", "body name=\"ball\"", "body name=\"base\"", "there are two bodies of this name"},
        MjcfFault{"TwoGeoms", "name=\"floor\"", "name=\"pad\"", "there are two geoms of this name"},
        MjcfFault{"TwoJoints", "name=\"slide\"", "name=\"elbow\"", "there are two joints of this name"},
        MjcfFault{"Exclude", "body2=\"rail\"", "body2=\"rai\"", "there is no body 'rai'; did you mean 'rail'?"},
        MjcfFault{"Pair", "geom1=\"pad\"", "geom1=\"pat\"", "there is no geom 'pat'"},
        MjcfFault{"Key", "qpos=\"1 0.5", "qpos=\"1 0.5 7", "key 'home': qpos has 11 numbers; the joints have 10"},
        MjcfFault{"Orientations", "euler=\"0 0 90\"", "euler=\"0 0 90\" zaxis=\"0 0 1\"", "has two orientations"},
        MjcfFault{"Quat", "body name=\"ball\"", "body name=\"ball\" quat=\"0 0 0 0\"", "quat has length 0"},
        MjcfFault{"FromTo", "fromto=\"0 0 0 0 0 0.5\"", "fromto=\"1 0 0 1 0 0\"", "fromto has no length"},
        MjcfFault{"Mask", "contype=\"2\"", "contype=\"0.5\"", "contype is 0.5; must be a whole number"},
        MjcfFault{"Global", "<compiler", "<compiler coordinate=\"global\"", "global coordinates are not read"},
        MjcfFault{"Euler", "<compiler", "<compiler eulerseq=\"xyw\"", "eulerseq is 'xyw'"},
        MjcfFault{"Angle", "<compiler", "<compiler angle=\"grad\"", "angle is 'grad'; must be 'degree' or 'radian'"},
        MjcfFault{"Terrain", "type=\"plane\"", "type=\"hfield\"", "geoms of type hfield are not read"},
        MjcfFault{"Fitted", "type=\"plane\"", "type=\"box\" mesh=\"wedge\"",
                  "a box that is fitted to a mesh is not read"},
        MjcfFault{"Composite", "<freejoint/>", "<composite/>", "composite: is not read; let MuJoCo expand the model"},
        MjcfFault{"Include", "settings.xml", "http://a/b.xml", "is an address"},
        MjcfFault{"NoEnd", "</mujoco>", "", "not well-formed XML"}),
    [](const auto& each) { return each.param.name; });

TEST_F(MjcfFile, TakesNoSrdf)
{
    const auto path = folder.write("arm.xml", arm);
    try {
        load_robot(path, {.srdf = path});
        FAIL() << "an SRDF file is read";
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::usage) << error.what();
    }
}

TEST_F(MjcfFile, ReadsLongChainsInLinearTime)
{
    const auto of = [&](int bodies) {
        std::string text = "<mujoco><worldbody>\n";
        for (int i = 0; i < bodies; ++i)
            text += fmt::format("<body name='b{}' pos='{} 0 0'><joint/><geom size='0.1'/></body>\n", i, i);
        return load_robot(folder.write("many.xml", text + "</worldbody></mujoco>")).links.size();
    };
    EXPECT_EQ(of(3000), 3001u);
}

} // namespace
} // namespace oncollide::mjcf_file_test
