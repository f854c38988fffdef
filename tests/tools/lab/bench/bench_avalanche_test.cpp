#include <algorithm>

#include "tools/command_fixture.hpp"
#include "tools/csv_rows.hpp"
#include <oncollide/samples/catalogue.hpp>
#include <oncollide/scenes/files/scene_file.hpp>

namespace oncollide::test {
namespace {

TEST_F(CommandLine, BenchAvalancheComesToRestAboveTheHill)
{
    const Outcome outcome = run({"bench", "avalanche", "--bodies", "32", "--csv", "a.csv"});
    EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
    const auto rows = read_csv(folder_.read("a.csv"));
    double most_contacts = 0;
    bool rests = false;
    for (auto row : rows) {
        if (!row["who"].starts_with("oncollide")) continue;
        EXPECT_EQ(row["lost"], "0") << row["s"];
        most_contacts = std::max(most_contacts, std::stod(row["contacts"]));
        if (row["who"] != "oncollide, at rest") continue;
        rests = true;
        EXPECT_EQ(row["awake"], "0");
    }
    EXPECT_TRUE(rests);
    EXPECT_GE(most_contacts, 32) << "each body lies on something";
    EXPECT_GT(std::stod(rows.front().at("awake")), 20) << "they fall at first";
}

TEST_F(CommandLine, BenchAvalancheWritesWhatItPlaysAsASceneWithARecording)
{
    const Outcome outcome = run({"bench", "avalanche", "--bodies", "21", "--seconds", "2", "--only", "oncollide",
                                 "--record", "slide.json", "--record-every", "25"});
    EXPECT_TRUE(outcome.code == 0 || outcome.code == 70) << outcome.out << outcome.err;
    Scene scene = load_scene(folder_ / "slide.json", {.generators = &sample_generators()});
    EXPECT_EQ(scene.size(), 22u);
    EXPECT_EQ(scene.frames, 11) << "the start, and 10 of 250 steps";
    const Scene start = make_scene("avalanche", {.bodies = 21});
    EXPECT_EQ(scene.names[21], "gear-20");
    EXPECT_TRUE(scene.start_pose(5).isApprox(start.start_pose(5), 1e-6));
    Mover().move(scene, 10);
    for (std::size_t i = 1; i < scene.size(); ++i)
        EXPECT_LT(scene.poses[i].translation().z(), scene.start_pose(i).translation().z() - 0.1) << i;
}

TEST_F(CommandLine, BenchAvalancheReportsBodiesThatStillMove)
{
    EXPECT_EQ(run({"bench", "avalanche", "--bodies", "10", "--seconds", "1", "--only", "oncollide"}).code, 70);
}

} // namespace
} // namespace oncollide::test
