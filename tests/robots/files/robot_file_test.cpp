#include <gtest/gtest.h>

#include "robots/small_robot.hpp"
#include <oncollide/robots/robot.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

namespace oncollide::robot_file_test {
namespace {

using test::SmallRobot;

class RobotFile : public ::testing::Test {
protected:
    /// Without programs, such as xacro.
    void SetUp() override { ::setenv("PATH", "", 1); }
    void TearDown() override { ::setenv("PATH", path_before.c_str(), 1); }
    RobotDescription load(const std::filesystem::path& urdf, const std::filesystem::path& srdf = {}) const
    {
        return load_robot(urdf, {.srdf = srdf, .packages = {{"robot", files.folder().path()}}});
    }
    std::string error_of(const std::filesystem::path& urdf, const std::filesystem::path& srdf = {}) const
    {
        try {
            load(urdf, srdf);
        } catch (const Error& error) {
            EXPECT_EQ(error.kind(), ErrorKind::bad_data) << error.what();
            return error.what();
        }
        return "no error";
    }
    SmallRobot files;
    const std::string path_before = std::getenv("PATH") ? std::getenv("PATH") : "";
};

TEST_F(RobotFile, HasTheTreeAndTheShapesOfTheFile)
{
    const RobotDescription robot = load(files.urdf);
    EXPECT_EQ(robot.name, "arm");
    ASSERT_EQ(robot.links.size(), 6u);
    ASSERT_EQ(robot.joints.size(), 5u);
    const RobotJoint& elbow = robot.joints[1];
    EXPECT_EQ(elbow.kind, JointKind::revolute);
    EXPECT_EQ(robot.links[elbow.parent].name, "upper");
    EXPECT_EQ(robot.links[elbow.child].name, "lower");
    EXPECT_EQ(elbow.lower, -3);
    EXPECT_EQ(elbow.upper, 2.5);
    EXPECT_EQ(robot.joints[0].axis, Eigen::Vector3d::UnitZ()); // of length 1
    const RobotJoint& mimic = robot.joints[3];
    EXPECT_EQ(mimic.mimics, 2);
    EXPECT_EQ(mimic.multiplier, -2);
    EXPECT_EQ(mimic.offset, 0.01);
    EXPECT_EQ(std::get<Box>(std::get<Shape>(robot.links[0].collision.at(0).geometry->data)).half,
              Eigen::Vector3d(0.15, 0.15, 0.25));
    EXPECT_EQ(robot.links[1].collision.at(0).pose.translation(), Eigen::Vector3d(0, 0, 0.25));
    EXPECT_TRUE(robot.links[5].collision.empty());
    // Without an SRDF file, the two links of each joint are an excluded pair.
    EXPECT_EQ(robot.excluded.size(), 5u);
}

TEST_F(RobotFile, ScalesEachAxisAndKeepsMirroredMeshesOriented)
{
    const RobotDescription robot = load(files.urdf);
    const Mesh& lower = std::get<Mesh>(robot.links[2].collision.at(0).geometry->data);
    EXPECT_TRUE(lower.bounds.max.isApprox(Eigen::Vector3d(0.05, 0.05, 0.4)));
    const Mesh& right = std::get<Mesh>(robot.links[4].collision.at(0).geometry->data);
    EXPECT_TRUE(right.bounds.min.isApprox(Eigen::Vector3d(-0.02, 0, 0)));
    double volume = 0; // positive: outward
    for (const Triangle& t : right.triangles)
        volume += right.vertices[t[0]].dot(right.vertices[t[1]].cross(right.vertices[t[2]])) / 6;
    EXPECT_NEAR(volume, 8e-6 / 6, 1e-9);
}

TEST_F(RobotFile, FindsPackagesAboveTheFile)
{
    const auto text =
        std::string(SmallRobot::text).replace(SmallRobot::text.find("package://robot/"), 16, "package://");
    std::filesystem::create_directories(files.folder() / "meshes");
    std::filesystem::create_directories(files.folder() / "urdf");
    std::filesystem::copy(files.folder() / "wedge.obj", files.folder() / "meshes/wedge.obj");
    std::filesystem::copy(files.folder() / "wedge.obj", files.folder() / "urdf/wedge.obj");
    std::string inside = text;
    inside.replace(inside.find("package://wedge"), 15, "package://meshes/wedge");
    const auto path = files.folder().write("urdf/arm.urdf", inside);
    EXPECT_EQ(load_robot(path).links.size(), 6u);
}

TEST_F(RobotFile, ReadsGroupsStatesAndExcludedPairs)
{
    const RobotDescription robot = load(files.urdf, files.srdf);
    ASSERT_EQ(robot.groups.size(), 3u);
    EXPECT_EQ(robot.groups[0].links, (std::vector<std::uint32_t>{0, 1, 2}));
    EXPECT_EQ(robot.groups[0].joints, (std::vector<std::uint32_t>{0, 1}));
    EXPECT_EQ(robot.groups[2].joints, (std::vector<std::uint32_t>{0, 1, 2, 3}));
    ASSERT_EQ(robot.states.size(), 1u);
    EXPECT_EQ(robot.states[0].values.at(0).numbers, std::vector<double>{1.5});
    const std::vector<std::pair<std::uint32_t, std::uint32_t>> excluded{{0, 1}, {1, 2}};
    EXPECT_EQ(robot.excluded, excluded);
}

TEST_F(RobotFile, FindsModelsOfGazeboAndFilesByAddressOfThisMachine)
{
    const auto named = [&](const std::string& file) {
        return files.changed("filename=\"wedge.obj\"", "filename=\"" + file + "\"");
    };
    const std::string here = (files.folder() / "wedge.obj").string();
    for (const std::string& file : {std::string("model://robot/wedge.obj"), "file://" + here, here})
        EXPECT_EQ(load(named(file)).links.size(), 6u) << file;
    EXPECT_NE(error_of(named("model://nowhere/wedge.obj")).find("name the folder of model 'nowhere'"),
              std::string::npos);
    for (const char* file : {"http://localhost/wedge.obj", "https://localhost/wedge.obj", "ftp+x://a/b"})
        EXPECT_NE(
            error_of(named(file)).find(std::string(file) + ": is an address; files are read from this machine only"),
            std::string::npos)
            << error_of(named(file));
}

TEST_F(RobotFile, AMimicJointWithoutLimitsIsReadWithAWarning)
{
    static std::vector<std::string> warnings;
    warnings.clear();
    on_file_warning([](const std::string& line) { warnings.push_back(line); });
    const auto path = files.changed("<limit lower=\"-1\" upper=\"1\"/>", "");
    const RobotDescription robot = load(path);
    on_file_warning(nullptr);
    EXPECT_EQ(robot.joints[3].mimics, 2);
    EXPECT_EQ(robot.joints[3].lower, -std::numeric_limits<double>::infinity());
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_TRUE(warnings[0].starts_with(path.string() + ": joint 'slide2' has no limit")) << warnings[0];
}

struct Fault {
    const char *name, *from, *to, *message;
};

class RobotFault : public RobotFile, public ::testing::WithParamInterface<Fault> {};

TEST_P(RobotFault, IsAnErrorThatNamesFileLineAndElement)
{
    const Fault& fault = GetParam();
    const std::string error = error_of(files.changed(fault.from, fault.to));
    EXPECT_NE(error.find("changed.urdf: line "), error.npos) << error;
    EXPECT_NE(error.find(fault.message), error.npos) << error;
}

INSTANTIATE_TEST_SUITE_P(
    Urdf, RobotFault,
    ::testing::Values(
        Fault{"Loop", "<link name=\"camera\"/>",
              "<link name=\"camera\"/><joint name=\"back\" type=\"fixed\"><parent link=\"camera\"/><child "
              "link=\"lower\"/></joint>",
              "joint 'back': link 'lower' is already the child of joint 'elbow'"},
        Fault{"Ring", "<link name=\"camera\"/>",
              "<link name=\"camera\"/><joint name=\"back\" type=\"fixed\"><parent link=\"camera\"/><child "
              "link=\"base\"/></joint>",
              "form a loop"},
        Fault{"TwoRoots", "<link name=\"camera\"/>", "<link name=\"camera\"/><link name=\"loose\"/>",
              "line 23: link 'loose': is a second root, beside 'base'"},
        Fault{"MissingMesh", "filename=\"wedge.obj\"", "filename=\"no.obj\"", "no.obj"},
        Fault{"UnknownPackage", "package://robot/", "package://nowhere/", "'nowhere'"},
        Fault{"UnknownLink", "<child link=\"upper\"/>", "<child link=\"uper\"/>",
              "line 5: joint 'turn': the robot has no link 'uper'; did you mean 'upper'?"},
        Fault{"UnknownMimic", "<mimic joint=\"slide\"", "<mimic joint=\"slip\"", "no joint 'slip'"},
        Fault{"MimicOfItself", "<mimic joint=\"slide\"", "<mimic joint=\"slide2\"", "mimics itself"},
        Fault{"NanOrigin", "xyz=\"0 0 0.25\"", "xyz=\"0 nan 0.25\"", "'nan' is not a finite number"},
        Fault{"TwoNumbers", "xyz=\"0 0 0.25\"", "xyz=\"0 0.25\"", "xyz has 2 numbers; it must have 3"},
        Fault{"ZeroScale", "scale=\"0.05 0.05 0.4\"", "scale=\"0.05 0 0.4\"", "a scale of 0"},
        Fault{"ZeroRadius", "<sphere radius=\"0.02\"/>", "<sphere radius=\"0\"/>", "radius is 0"},
        Fault{"NoLimit", "<limit lower=\"-3\" upper=\"2.5\"/>", "", "joint 'elbow': a revolute joint needs a limit"},
        Fault{"LimitsReversed", "lower=\"-3\"", "lower=\"3\"", "its limits are 3 to 2.5"},
        Fault{"NoAxis", "<axis xyz=\"0 0 2\"/>", "<axis xyz=\"0 0 0\"/>", "its axis has no direction"},
        Fault{"UnknownType", "type=\"continuous\"", "type=\"hinge\"", "unknown type 'hinge'"},
        Fault{"TwoLinksOfOneName", "<link name=\"camera\"/>", "<link name=\"camera\"/><link name=\"base\"/>",
              "two links of this name"},
        Fault{"XacroExpression", "radius=\"0.04\"", "radius=\"${r}\"", "xacro "},
        Fault{"XacroMacro", "<link name=\"camera\"/>", "<link name=\"camera\"/><xacro:macro name=\"m\"/>",
              "the file is for xacro; expand it first: xacro "},
        Fault{"NoRobot", "</robot>", "", "not well-formed XML"}),
    [](const auto& each) { return each.param.name; });

TEST_F(RobotFile, RefusesXacroAndOtherFiles)
{
    const auto xacro = files.folder().write("arm.xacro", SmallRobot::text);
    EXPECT_NE(error_of(xacro).find("expand it first: xacro "), std::string::npos);
    const auto model = files.folder().write("model.urdf", "<sdf version='1.6'/>");
    EXPECT_NE(error_of(model).find("is neither URDF nor MJCF"), std::string::npos);
    try {
        load(files.folder() / "no.urdf");
        FAIL() << "a missing file is read";
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::no_input);
    }
}

TEST_F(RobotFile, RefusesAnSrdfThatDoesNotFit)
{
    EXPECT_NE(error_of(files.urdf, files.changed_srdf("<robot name=\"arm\">", "<robot name=\"leg\">"))
                  .find("for another robot than 'arm'"),
              std::string::npos);
    EXPECT_NE(error_of(files.urdf, files.changed_srdf("link1=\"lower\"", "link1=\"lowr\""))
                  .find("line 7: disable_collisions: the robot has no link 'lowr'"),
              std::string::npos);
    EXPECT_NE(error_of(files.urdf, files.changed_srdf("base_link=\"base\"", "base_link=\"left\"")).find("is not above"),
              std::string::npos);
    EXPECT_NE(error_of(files.urdf, files.changed_srdf("value=\"1.5\"", "value=\"inf\"")).find("'inf' is not a finite"),
              std::string::npos);
}

} // namespace
} // namespace oncollide::robot_file_test
