#include "robots/small_robot.hpp"
#include "tools/command_fixture.hpp"

namespace oncollide::test {
namespace {

class RobotCommandLine : public CommandLine {
protected:
    void SetUp() override
    {
        if (robot({"--quiet"}).err.find("build without the readers of URDF") != std::string::npos)
            GTEST_SKIP() << "ONCOLLIDE_XML is off";
    }
    std::vector<std::string> with(std::vector<std::string> more) const
    {
        std::vector<std::string> arguments{"robot",     robot_.urdf.string(),
                                           "--srdf",    robot_.srdf,
                                           "--package", "robot=" + robot_.folder().path().string()};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return arguments;
    }
    Outcome robot(std::vector<std::string> more) { return run(with(std::move(more))); }
    SmallRobot robot_;
};

TEST_F(RobotCommandLine, TellsWhichConfigurationsCollide)
{
    folder_.write("q.csv",
                  "# folded, straight, into the wall\nturn, elbow, slide\n0.4,-3,0.05\n0,0,0.05\n0,1.4,0.05\n");
    folder_.write("wall.obj", "v 0.3 -2 0.4\nv 0.3 2 0.4\nv 0.3 0 2\nf 1 2 3\n");
    const Outcome outcome =
        robot({"--world", "wall.obj", "--configurations", "q.csv", "--json", "r.json", "--csv", "-"});
    EXPECT_EQ(outcome.code, 1) << outcome.err;
    const nlohmann::json json = read_json("r.json");
    EXPECT_EQ(json.at("configurations"), 3);
    EXPECT_EQ(json.at("colliding"), 2);
    EXPECT_EQ(json.at("results").at(0).at("verdict"), "colliding");
    EXPECT_EQ(json.at("results").at(0).at("other_link").get<std::string>() == "base" ||
                  json.at("results").at(0).at("link").get<std::string>() == "base",
              true);
    EXPECT_EQ(json.at("results").at(1).at("verdict"), "separate");
    EXPECT_EQ(json.at("results").at(2).at("body"), "wall.obj");
    EXPECT_NE(outcome.out.find("2,colliding,0,"), std::string::npos) << outcome.out;
    EXPECT_EQ(robot({"--world", "wall.obj", "--no-self", "--configurations", "q.csv"}).code, 1);
    EXPECT_EQ(robot({"--state", "bent"}).code, 0);
}

TEST_F(RobotCommandLine, PaddingAndAllowedContacts)
{
    folder_.write("q.csv", "turn,elbow,slide\n0,0,0.05\n0,1.4,0.05\n");
    folder_.write("wall.obj", "v 0.3 -2 0.4\nv 0.3 2 0.4\nv 0.3 0 2\nf 1 2 3\n");
    const auto verdicts = [&](std::vector<std::string> more) {
        std::vector<std::string> all{"--world", "wall.obj", "--configurations", "q.csv", "--no-self",
                                     "--json",  "r.json"};
        all.insert(all.end(), more.begin(), more.end());
        const Outcome outcome = robot(all);
        EXPECT_LE(outcome.code, 2) << outcome.err;
        std::string found;
        const nlohmann::json json = read_json("r.json");
        for (const auto& result : json.at("results")) found += result.at("verdict").get<std::string>() + " ";
        return found;
    };
    EXPECT_EQ(verdicts({}), "separate colliding ");
    EXPECT_EQ(verdicts({"--padding", "300mm"}), "within within ") << "the first pair ends a configuration";
    EXPECT_EQ(verdicts({"--link-padding", "upper=0.3"}), "within colliding ");
    EXPECT_EQ(verdicts({"--allow", "lower=wall.obj", "--allow", "left=wall.obj", "--allow", "right=wall.obj"}),
              "separate separate ");
    EXPECT_EQ(verdicts({"--path", "--padding", "20cm"}), "within ");
    expect_error(64, with({"--world", "wall.obj", "--link-padding", "upper"}), {"--link-padding upper", "LINK=LENGTH"});
    expect_error(64, with({"--world", "wall.obj", "--link-padding", "uper=1mm"}), {"no link 'uper'", "upper"});
    expect_error(64, with({"--world", "wall.obj", "--allow", "upper=roof"}), {"--allow", "'roof'", "wall.obj"});
    expect_error(64, with({"--world", "wall.obj", "--padding", "-1"}), {"--padding"});
}

TEST_F(RobotCommandLine, APaddingFileHoldsClearancesAndAllowedContacts)
{
    folder_.write("q.csv", "turn,elbow,slide\n0,0,0.05\n0,1.4,0.05\n");
    folder_.write("wall.obj", "v 0.3 -2 0.4\nv 0.3 2 0.4\nv 0.3 0 2\nf 1 2 3\n");
    const auto verdicts = [&](const std::string& yaml, std::vector<std::string> more = {}) {
        folder_.write("p.yaml", yaml);
        std::vector<std::string> all{"--world", "wall.obj", "--configurations", "q.csv",  "--no-self",
                                     "--json",  "r.json",   "--padding-file",   "p.yaml", "--quiet"};
        all.insert(all.end(), more.begin(), more.end());
        const Outcome outcome = robot(all);
        if (outcome.code > 2) return outcome.err;
        std::string found;
        const nlohmann::json json = read_json("r.json");
        for (const auto& result : json.at("results")) found += result.at("verdict").get<std::string>() + " ";
        return found;
    };
    const std::string first = verdicts("environment: 300mm\n");
    if (first.find("libyaml-cpp-dev") != first.npos) GTEST_SKIP() << "yaml-cpp is absent";
    EXPECT_EQ(first, "within within ");
    EXPECT_EQ(verdicts("environment: 300mm\n", {"--padding", "0"}), "separate colliding ");
    EXPECT_EQ(verdicts("links: {upper: 0.3}\n"), "within colliding ");
    EXPECT_EQ(verdicts("links: {upper: 0.3}\n", {"--link-padding", "upper=0"}), "separate colliding ");
    EXPECT_EQ(verdicts("bodies: {wall.obj: 30cm}\n"), "within within ");
    EXPECT_EQ(verdicts("bodies: {wall.obj: 30cm}\n"
                       "pairs:\n- {names: [upper, wall.obj], clearance: 0}\n- {names: [base, wall.obj], clearance: 0}\n"
                       "- {names: [lower, wall.obj], clearance: 0}\n- {names: [left, wall.obj], clearance: 0}\n"
                       "- {names: [right, wall.obj], clearance: 0}\n"),
              "separate colliding ");
    EXPECT_EQ(verdicts("allowed: [[lower, wall.obj], [left, wall.obj], [right, wall.obj]]\n"), "separate separate ");
    EXPECT_EQ(robot({"--state", "bent"}).code, 0);
    folder_.write("self.yaml", "self: 0\npairs: [{names: [base, lower], clearance: 5 m}]\n");
    EXPECT_EQ(robot({"--state", "bent", "--padding-file", "self.yaml"}).code, 2);
    folder_.write("self.yaml", "pairs: [{names: [base, lower], clearance: 5 m}]\nallowed: [[base, lower]]\n");
    EXPECT_EQ(robot({"--state", "bent", "--padding-file", "self.yaml"}).code, 0);
    for (const auto& [yaml, words] :
         {std::pair("enviroment: 1\n", "line 1: unknown key 'enviroment'; did you mean 'environment'"),
          {"self: 0\nlinks: {uper: 1mm}\n", "line 2: no link 'uper'; did you mean 'upper'"},
          {"bodies: {roof: 1}\n", "line 1: the environment has no body 'roof'"},
          {"self: [1]\n", "line 1: a clearance is missing"},
          {"self: -1\n", "line 1: a clearance"},
          {"self: .nan\n", "line 1: a clearance"},
          {"self: 2e6\n", "must be at most 1e6 m"},
          {"allowed: [[upper]]\n", "a list of two names"},
          {"allowed: [[upper, roof]]\n", "no link or body 'roof'"},
          {"pairs: [{names: [upper, lower]}]\n", "line 1: has no clearance"},
          {"- 1\n", "must be a map"},
          {"self: [\n", "line 2: "}}) {
        folder_.write("p.yaml", yaml);
        expect_error(65, with({"--world", "wall.obj", "--padding-file", "p.yaml"}), {"p.yaml: ", words});
    }
    expect_error(66, with({"--padding-file", "none.yaml"}), {"none.yaml"});
}

TEST_F(RobotCommandLine, WarnsOfConfigurationsOutOfTheLimitsOfJoints)
{
    folder_.write("q.csv", "turn,elbow,slide\n9,0,0.05\n0,2.9,0.05\n0,0,0.05\n0,0,0.2\n");
    const Outcome outcome = robot({"--configurations", "q.csv"});
    EXPECT_EQ(outcome.err, "oncollide: warning: 2 of 4 configurations are out of the limits of a joint; the first is "
                           "configuration 1: joint 'elbow': 2.9 is out of its limits, -3 to 2.5 (--limits refuse: an "
                           "error)\n"
                           "oncollide: note: 1 of 6 links has no collision geometry: 'camera'\n");
    EXPECT_LE(outcome.code, 1);
    EXPECT_EQ(robot({"--configurations", "q.csv", "--quiet"}).err, "");
    EXPECT_EQ(robot({"--configurations", "q.csv", "--limits", "ignore"}).err,
              "oncollide: note: 1 of 6 links has no collision geometry: 'camera'\n");
    EXPECT_EQ(robot({"--configurations", "q.csv", "--limits", "warn"}).err, outcome.err);
    expect_error(64, with({"--configurations", "q.csv", "--limits", "refus"}), {"--limits", "did you mean 'refuse'"});
    expect_error(65, with({"--configurations", "q.csv", "--limits", "refuse"}),
                 {"configuration 1", "joint 'elbow'", "2.9 is out of its limits"});
}

TEST_F(RobotCommandLine, ReadsModelsOfMujoco)
{
    folder_.write("arm.xml", R"(<mujoco model="arm"><worldbody><geom type="plane"/>
        <body name="a" pos="0 0 0.5"><joint name="j" axis="0 1 0" range="-90 90"/>
        <geom type="capsule" fromto="0 0 0 0.6 0 0" size="0.05"/></body></worldbody>
        <keyframe><key name="down" qpos="1.5"/></keyframe></mujoco>)");
    EXPECT_EQ(run({"robot", "arm.xml", "--state", "qpos0"}).code, 0);
    const Outcome down = run({"robot", "arm.xml", "--state", "down"});
    EXPECT_EQ(down.code, 1);
    EXPECT_NE(down.out.find("configuration 0: colliding, link 'world' and link 'a'"), std::string::npos) << down.out;
    expect_error(64, {"robot", "arm.xml", "--srdf", "arm.xml"}, {"arm.xml: is MJCF"});
    folder_.write("bad.xml", "<mujoco><worldbody>\n<geom type='capsul'/></worldbody></mujoco>");
    expect_error(65, {"robot", "bad.xml"}, {"bad.xml: line 2: geom: unknown type 'capsul'; did you mean 'capsule'"});
}

TEST_F(RobotCommandLine, ExpandsFilesForXacroIfItIsOnThePath)
{
    std::filesystem::create_directories(folder_ / "bin");
    const auto with_xacro = [&](const std::string& script) {
        folder_.write("bin/xacro", "#!/bin/sh\n" + script);
        std::filesystem::permissions(folder_ / "bin/xacro", std::filesystem::perms::owner_all);
        Surroundings around;
        around.environment = {{"PATH", (folder_ / "bin").string() + ":/usr/bin:/bin"}};
        return run({"robot", "r.urdf.xacro", "--quiet"}, around);
    };
    folder_.write("r.urdf.xacro", "<robot name='r' xmlns:xacro='http://ros.org/wiki/xacro'>"
                                  "<xacro:macro name='m'/></robot>");
    folder_.write("made.urdf", R"(<robot name="r"><link name="a"><collision><geometry><sphere radius="1"/></geometry>
        </collision></link><joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint><link name="b"/>
        <joint name="k" type="fixed"><parent link="b"/><child link="c"/><origin xyz="0.5 0 0"/></joint>
        <link name="c"><collision><geometry><sphere radius="1"/></geometry></collision></link></robot>)");
    const std::string made = (folder_ / "made.urdf").string();
    EXPECT_EQ(with_xacro("cat " + made + "; test -f \"$1\" && test $# = 1").code, 1); // colliding
    Outcome outcome = with_xacro("echo 'undefined property: r' >&2; exit 2");
    EXPECT_EQ(outcome.code, 65);
    EXPECT_NE(outcome.err.find("/bin/xacro failed with exit code 2: undefined property: r"), std::string::npos)
        << outcome.err;
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1);
    outcome = with_xacro("kill -9 $$");
    EXPECT_NE(outcome.err.find("was killed by signal 9"), std::string::npos) << outcome.err;
    outcome = with_xacro("true");
    EXPECT_NE(outcome.err.find("wrote nothing"), std::string::npos) << outcome.err;
    outcome = with_xacro("echo '<robot name=\"r\"><link/>\n</robot>'");
    EXPECT_EQ(outcome.code, 65);
    EXPECT_NE(outcome.err.find("r.urdf.xacro, expanded: line 1: link: has no attribute 'name'"), std::string::npos)
        << outcome.err;
    outcome = with_xacro("yes");
    EXPECT_NE(outcome.err.find("wrote more than 64 MB"), std::string::npos) << outcome.err;
    std::filesystem::remove(folder_ / "bin/xacro");
    Surroundings without;
    without.environment = {{"PATH", "bin"}};
    outcome = run({"robot", "r.urdf.xacro"}, without);
    EXPECT_NE(outcome.err.find("expand it first: xacro r.urdf.xacro > r.urdf"), std::string::npos) << outcome.err;
}

TEST_F(RobotCommandLine, AComparisonWithNothingIsAnError)
{
    expect_error(64, with({"--no-self"}), {"--no-self: needs --world"});
    folder_.write("bare.urdf", R"(<robot name="bare"><link name="a"/></robot>)");
    expect_error(65, {"robot", "bare.urdf"}, {"bare.urdf", "no link has collision geometry"});
    folder_.write("one.urdf", R"(<robot name="one"><link name="a"><collision><geometry><sphere radius="1"/></geometry>
                                 </collision></link></robot>)");
    folder_.write("empty.json", R"({"geometries": {}, "bodies": []})");
    expect_error(65, {"robot", "one.urdf"}, {"compared with nothing", "the environment has no body"});
    expect_error(65, {"robot", "one.urdf", "--world", "empty.json", "--no-self"}, {"empty.json has no body"});
}

TEST_F(RobotCommandLine, NamesInItsTableAreNoFormulas)
{
    folder_.write("r.urdf", R"(<robot name="r">
        <link name="=1+2"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
        <joint name="j" type="fixed"><parent link="=1+2"/><child link="mid"/></joint><link name="mid"/>
        <joint name="k" type="fixed"><parent link="mid"/><child link="@b"/></joint>
        <link name="@b"><collision><geometry><sphere radius="0.1"/></geometry></collision></link></robot>)");
    EXPECT_EQ(run({"robot", "r.urdf", "--csv", "r.csv"}).code, 2 - 1);
    const std::string csv = folder_.read("r.csv");
    EXPECT_NE(csv.find("\"'=1+2\""), std::string::npos) << csv;
    EXPECT_NE(csv.find("\"'@b\""), std::string::npos) << csv;
    // A model of spheres is read back with the links' own names.
    ASSERT_EQ(run({"spheres", "r.urdf", "--max-error", "10cm", "--csv", "s.csv"}).code, 0);
    EXPECT_NE(folder_.read("s.csv").find("\"'=1+2\""), std::string::npos);
    const Outcome judged = run({"spheres", "r.urdf", "--judge", "s.csv"});
    EXPECT_EQ(judged.code, 0) << judged.err;
    EXPECT_EQ(judged.err, "");
}

TEST_F(RobotCommandLine, AnInterruptKeepsWhatWasFinished)
{
    folder_.write("wall.obj", "v 0.3 -2 0.4\nv 0.3 2 0.4\nv 0.3 0 2\nf 1 2 3\n");
    std::string rows = "turn,elbow,slide\n";
    for (int k = 0; k < 400'000; ++k) rows += k % 2 ? "0,0,0.05\n" : "0.3,1.2,0.05\n";
    folder_.write("q.csv", rows);
    for (const bool path : {false, true}) {
        Surroundings around;
        around.meanwhile = [&](pid_t child) {
            ::usleep(path ? 1'500'000 : 400'000);
            ::kill(child, SIGINT);
        };
        std::vector<std::string> words =
            with({"--world", "wall.obj", "--configurations", "q.csv", "--csv", "r.csv", "--json", "r.json"});
        if (path) words.push_back("--path");
        const Outcome outcome = run(words, around);
        if (outcome.code != 130) continue; // it was done, or had not begun
        const nlohmann::json json = read_json("r.json");
        const auto done = json.at(path ? "motions" : "configurations").get<std::size_t>();
        EXPECT_TRUE(json.at("interrupted").get<bool>());
        EXPECT_LT(done, 400'000u);
        EXPECT_EQ(json.at("results").size(), done);
        EXPECT_NE(outcome.err.find(fmt::format("oncollide: interrupted after {} of ", done)), std::string::npos)
            << outcome.err;
        EXPECT_NE(outcome.err.find("their results are in r.json, r.csv"), std::string::npos) << outcome.err;
        const std::string csv = folder_.read("r.csv");
        EXPECT_EQ(std::size_t(std::ranges::count(csv, '\n')), done + 1);
    }
}

TEST_F(RobotCommandLine, SetsTheNamedColumnsOverTheState)
{
    folder_.write("turns.csv", "turn\n0\n1\n");
    folder_.write("wall.obj", "v 0.3 -2 0.4\nv 0.3 2 0.4\nv 0.3 0 2\nf 1 2 3\n");
    // The bent arm reaches the wall where it turns towards it.
    const Outcome bent =
        robot({"--world", "wall.obj", "--configurations", "turns.csv", "--state", "bent", "--json", "r.json"});
    EXPECT_EQ(bent.code, 1) << bent.err;
    EXPECT_EQ(read_json("r.json").at("results").at(0).at("verdict"), "colliding");
    EXPECT_EQ(robot({"--world", "wall.obj", "--configurations", "turns.csv"}).code, 0);
    folder_.write("group.csv", "0,1.5\n");
    EXPECT_EQ(robot({"--world", "wall.obj", "--configurations", "group.csv", "--group", "chain"}).code, 1);
}

TEST_F(RobotCommandLine, AnErrorBoundLeavesConfigurationsWithin)
{
    // The left finger passes the slanting wall at 1 mm.
    folder_.write("q.csv", "turn,elbow,slide\n-0.5,0,0.05\n");
    folder_.write("wall.obj", "v 0.554708 -0.5 1\nv -0.445292 0.5 1\nv 0.054708 0 1.3\nf 1 2 3\n");
    EXPECT_EQ(robot({"--world", "wall.obj", "--configurations", "q.csv", "--json", "e.json"}).code, 0);
    EXPECT_EQ(robot({"--world", "wall.obj", "--configurations", "q.csv", "--max-error", "1"}).code, 0);
    const Outcome outcome = robot(
        {"--world", "wall.obj", "--configurations", "q.csv", "--max-error", "1", "--exact", "off", "--json", "r.json"});
    EXPECT_EQ(outcome.code, 2) << outcome.out;
    EXPECT_EQ(read_json("r.json").at("within"), 1);
}

TEST_F(RobotCommandLine, RefusesConfigurationsThatDoNotFit)
{
    folder_.write("wide.csv", "1,2\n");
    expect_error(65, with({"--configurations", "wide.csv"}), {"wide.csv", "has 2 columns", "turn, elbow, slide"});
    folder_.write("name.csv", "turn,elbo,slide\n1,2,3\n");
    expect_error(65, with({"--configurations", "name.csv"}), {"name.csv: line 1", "'elbo'", "did you mean 'elbow'"});
    folder_.write("nan.csv", "0,0,0.05\n1,nan,3\n");
    expect_error(65, with({"--configurations", "nan.csv"}), {"nan.csv: line 2", "'nan'"});
    folder_.write("limit.csv", "0,2.9,0.05\n");
    expect_error(65, with({"--configurations", "limit.csv", "--limits", "refuse"}),
                 {"configuration 0", "joint 'elbow'", "2.9 is out of its limits"});
    folder_.write("short.npy", "\x93NUMPY");
    expect_error(65, with({"--configurations", "short.npy"}), {"short.npy"});
    expect_error(66, with({"--configurations", "none.csv"}), {"none.csv"});
    expect_error(64, with({"--configurations", "q.txt"}), {"unknown kind of table '.txt'"});
    expect_error(64, with({"--state", "bend"}), {"no state 'bend'", "bent"});
    expect_error(64, with({"--configurations", "limit.csv", "--group", "arm"}), {"no group 'arm'", "chain"});
    expect_error(65,
                 {"robot", robot_.changed("<link name=\"camera\"/>", "").string(), "--package",
                  "robot=" + robot_.folder().path().string()},
                 {"changed.urdf: line 22: joint 'tip'", "no link 'camera'"});
}

TEST_F(RobotCommandLine, MakesSpheresThatTheJudgeFindsComplete)
{
    const std::string package = "robot=" + robot_.folder().path().string();
    const Outcome made = run({"spheres", robot_.urdf.string(), "--package", package, "--max-error", "10mm", "--yaml",
                              "s.yml", "--urdf", "s.urdf", "--csv", "s.csv", "--json", "made.json"});
    EXPECT_EQ(made.code, 0) << made.err;
    EXPECT_NE(made.out.find("misses no collision"), std::string::npos) << made.out;
    const nlohmann::json json = read_json("made.json");
    EXPECT_TRUE(json.at("complete").get<bool>());
    EXPECT_LE(json.at("over_reach").get<double>(), 0.01);
    EXPECT_GT(json.at("over_reach").get<double>(), 0.003);
    for (const char* model : {"s.yml", "s.urdf", "s.csv"}) {
        const Outcome judged =
            run({"spheres", robot_.urdf.string(), "--package", package, "--judge", model, "--json", "j.json"});
        EXPECT_EQ(judged.code, 0) << model << judged.err << judged.out;
        EXPECT_EQ(read_json("j.json").at("links"), json.at("links")) << model;
    }
    // The spherised robot has the kinematics of the original.
    folder_.write("q.csv", "turn,elbow,slide\n0.4,-3,0.05\n0,0,0.05\n");
    EXPECT_EQ(run({"robot", "s.urdf", "--configurations", "q.csv", "--json", "r.json"}).code, 1);
    EXPECT_EQ(read_json("r.json").at("results").at(0).at("verdict"), "colliding");
    EXPECT_EQ(read_json("r.json").at("results").at(1).at("verdict"), "separate");
}

TEST_F(RobotCommandLine, JudgesAModelWithAGap)
{
    // Half of the box of the base, and all of the rest.
    folder_.write("half.yml", "collision_spheres:\n  base:\n    - center: [0.15, 0, 0]\n      radius: 0.3\n"
                              "  elsewhere:\n    - {center: [0, 0, 0], radius: 1}\n");
    const std::string package = "robot=" + robot_.folder().path().string();
    const Outcome judged =
        run({"spheres", robot_.urdf.string(), "--package", package, "--judge", "half.yml", "--json", "j.json"});
    EXPECT_EQ(judged.code, 1) << judged.err;
    EXPECT_NE(judged.err.find("no link 'elsewhere'"), std::string::npos) << judged.err;
    const nlohmann::json base = read_json("j.json").at("links").at(0);
    // The farthest corner is at (-0.15, 0.15, 0.25).
    EXPECT_NEAR(base.at("gap").get<double>(), std::sqrt(0.09 + 0.0225 + 0.0625) - 0.3, 1e-9);
    EXPECT_GT(base.at("uncovered").get<double>(), 0);
    expect_error(64, {"spheres", robot_.urdf.string(), "--package", package}, {"--judge MODEL", "--count N"});
    expect_error(64, {"spheres", robot_.urdf.string(), "--package", package, "--count", "3"},
                 {"--count is 3", "5 links"});
    folder_.write("bad.yml", "collision_spheres:\n  base:\n    - center: [0, nan, 0]\n      radius: 0.3\n");
    expect_error(65, {"spheres", robot_.urdf.string(), "--package", package, "--judge", "bad.yml"},
                 {"bad.yml: line 3", "y is not a finite"});
    folder_.write("cut.yml", "collision_spheres: [");
    expect_error(65, {"spheres", robot_.urdf.string(), "--package", package, "--judge", "cut.yml"},
                 {"cut.yml: line 1"});
}

} // namespace
} // namespace oncollide::test
