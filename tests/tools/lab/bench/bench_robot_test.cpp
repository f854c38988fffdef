#include "robots/small_robot.hpp"
#include "tools/command_fixture.hpp"
#include "tools/csv_rows.hpp"

namespace oncollide::test {
namespace {

/// A board that the arm of SmallRobot meets on the way from its start to its goal.
constexpr const char* board = R"(world:
  collision_objects:
    - id: board
      pose:
        position: [0.35, 0, 0.8]
        orientation: [0, 0, 0, 1]
      primitives: [{type: box, dimensions: [0.02, 1, 1]}]
      primitive_poses: [{position: [0, 0, 0], orientation: [0, 0, 0, 1]}]
)";
constexpr const char* bend = R"(start_state:
  joint_state: {name: [turn, elbow, slide, absent], position: [0, 0, 0.05, 1]}
goal_constraints:
  - joint_constraints: [{joint_name: elbow, position: 1.4}, {joint_name: turn, position: 0.1}]
)";

class RobotBenchmarks : public CommandLine {
protected:
    void SetUp() override
    {
        std::filesystem::create_directories(folder_ / "problems" / "board");
        folder_.write("problems/board/scene0001.yaml", board);
        folder_.write("problems/board/request0001.yaml", bend);
        const std::string err = bench("robot", {"--each", "2", "--repeats", "1"}).err;
        if (err.find("build without") != std::string::npos) GTEST_SKIP() << err;
    }
    Outcome bench(const std::string& which, std::vector<std::string> more)
    {
        std::vector<std::string> arguments{"bench",
                                           which,
                                           robot_.urdf.string(),
                                           "--srdf",
                                           robot_.srdf,
                                           "--package",
                                           "robot=" + robot_.folder().path().string(),
                                           "--problems",
                                           "problems"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return run(arguments);
    }
    SmallRobot robot_;
};

TEST_F(RobotBenchmarks, ConfigurationsAgreeWithTheTruth)
{
    const Outcome outcome = bench("robot", {"--each", "30", "--repeats", "1", "--own-error", "20mm", "--csv", "r.csv"});
    EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
    const auto rows = read_csv(folder_.read("r.csv"));
    ASSERT_GE(rows.size(), 4u);
    for (const auto& row : rows) {
        EXPECT_EQ(row.at("missed"), "0") << row.at("who");
        EXPECT_EQ(row.at("self_missed"), "0") << row.at("who");
    }
}

TEST_F(RobotBenchmarks, DistancesAgreeWithChecks)
{
    const Outcome outcome = run({"bench", "robot-distances", robot_.urdf.string(), "--srdf", robot_.srdf, "--package",
                                 "robot=" + robot_.folder().path().string(), "--configurations", "100", "--repeats",
                                 "1", "--csv", "d.csv"});
    EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
    const auto rows = read_csv(folder_.read("d.csv"));
    ASSERT_EQ(rows.size(), 5u);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(rows[i].at("pairs"), "100");
    EXPECT_EQ(rows[0].at("differ"), "0");
    EXPECT_GT(std::stod(rows[0].at("meeting")), 5);
    EXPECT_LT(std::stod(rows[4].at("most_apart")), 1e-3);
    EXPECT_GT(std::stod(rows[0].at("gradients")), 20);
    EXPECT_LT(std::stod(rows[0].at("gradient_error")), 1e-6);
}

TEST_F(RobotBenchmarks, CertifiedMotionsAreNotRefuted)
{
    const Outcome outcome =
        bench("edges", {"--edges", "40", "--length", "1", "--samples", "300", "--repeats", "1", "--csv", "e.csv"});
    EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
    const auto rows = read_csv(folder_.read("e.csv"));
    ASSERT_EQ(rows.size(), 1u);
    EXPECT_EQ(rows[0].at("edges"), "40");
    EXPECT_EQ(rows[0].at("refuted"), "0");
    EXPECT_NE(rows[0].at("contacts"), "0");
    EXPECT_NE(rows[0].at("free"), "0");
}

TEST_F(RobotBenchmarks, FaultsOfProblemsNameTheFileAndTheLine)
{
    const auto fault = [&](const std::string& file, const std::string& text, const std::string& what) {
        folder_.write("problems/board/" + file, text);
        const Outcome outcome = bench("robot", {"--each", "2", "--repeats", "1"});
        EXPECT_EQ(outcome.code, 65) << file << outcome.err;
        EXPECT_NE(outcome.err.find(file), std::string::npos) << outcome.err;
        EXPECT_NE(outcome.err.find(what), std::string::npos) << outcome.err;
        folder_.write("problems/board/scene0001.yaml", board);
        folder_.write("problems/board/request0001.yaml", bend);
    };
    const auto changed = [](std::string text, const std::string& from, const std::string& to) {
        return text.replace(text.find(from), from.size(), to);
    };
    fault("scene0001.yaml", changed(board, "type: box", "type: torus"), "line 7: unknown primitive 'torus'");
    fault("scene0001.yaml", changed(board, "[0.02, 1, 1]", "[0.02, 1]"), "line 7: dimensions must be a list of 3");
    fault("scene0001.yaml", changed(board, "[0, 0, 0, 1]", "[0, 0, 0, 2]"),
          "line 5: the orientation is not of length 1");
    fault("scene0001.yaml", changed(board, "0.35", ".nan"), "position is not a finite number");
    fault("request0001.yaml", changed(bend, "0.05, 1]", "0.05]"), "line 2: name and position have different lengths");
    fault("request0001.yaml", "goal_constraints: [", "line 1");
    const std::string other =
        changed(changed(bend, "joint_name: elbow", "joint_name: e"), "joint_name: turn", "joint_name: t");
    fault("request0001.yaml", other, "its goal has no joint of 'arm'");
    std::filesystem::remove(folder_ / "problems" / "board" / "request0001.yaml");
    EXPECT_EQ(bench("robot", {}).code, 66);
    std::filesystem::remove_all(folder_ / "problems" / "board");
    const Outcome none = bench("robot", {});
    EXPECT_EQ(none.code, 66);
    EXPECT_NE(none.err.find("unpack the archive"), std::string::npos) << none.err;
}

} // namespace
} // namespace oncollide::test
