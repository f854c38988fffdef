// oncollide run --continuous.
#include "tools/command_fixture.hpp"
#include "tools/csv_rows.hpp"

namespace oncollide::test {
namespace {

TEST_F(CommandLine, AContinuousRunFindsContactsBetweenFrames)
{
    folder_.write("scene.json", R"({"frames": 3, "geometries": {
            "wall": {"shape": {"kind": "box", "half": [0.01, 5, 5]}},
            "bullet": {"shape": {"kind": "sphere", "radius": 0.005}}},
        "bodies": [{"geometry": "wall", "static": true},
                   {"geometry": "bullet", "position": [-9.5, 0, 0], "motion": {"drift": {"velocity": [10, 0, 0]}}}]})");
    const Outcome discrete = run({"run", "scene.json", "--exit-code"});
    EXPECT_EQ(discrete.code, 0) << discrete.out << discrete.err;
    const Outcome continuous = run({"run", "scene.json", "--exit-code", "--continuous"});
    EXPECT_EQ(continuous.code, 1) << continuous.out << continuous.err;
}

TEST_F(CommandLine, ResultsOfAContinuousRunSayWhenAndWhere)
{
    folder_.write("scene.json", R"({"frames": 3, "geometries": {
            "wall": {"mesh": {"generate": {"kind": "box", "half": [0.01, 5, 5]}}},
            "bullet": {"shape": {"kind": "sphere", "radius": 0.005}}},
        "bodies": [{"name": "wall", "geometry": "wall", "static": true},
                   {"name": "hit", "geometry": "bullet", "position": [-9.5, 1, 2], "motion": {"drift": {"velocity": [10, 0, 0]}}},
                   {"name": "near", "geometry": "bullet", "position": [-9.5, 5.004, 5.004], "motion": {"drift": {"velocity": [10, 0, 0]}}}]})");
    ASSERT_EQ(run({"run", "scene.json", "--continuous", "--separate", "--csv", "r.csv", "--json", "r.json"}).code, 0);
    const nlohmann::json frames = read_json("r.json").at("frames");
    EXPECT_TRUE(frames[0].at("sweeps").empty());
    ASSERT_EQ(frames[1].at("sweeps").size(), 2u);
    const nlohmann::json hit = frames[1]["sweeps"][0], miss = frames[1]["sweeps"][1];
    EXPECT_EQ(hit[0], "wall");
    EXPECT_EQ(hit[1], "hit");
    EXPECT_EQ(hit[2], "colliding");
    const double time = (9.5 - 0.015) / 10;
    EXPECT_LE(hit[3].get<double>(), time);
    EXPECT_GE(hit[4].get<double>(), time);
    EXPECT_LE(hit[4].get<double>() - hit[3].get<double>(), 1e-4);
    EXPECT_LE(hit[5].get<double>(), 1.1e-4);
    EXPECT_EQ(hit[6], false);
    EXPECT_TRUE(hit[7].is_string() && hit[8] == "0") << hit;
    EXPECT_NEAR(hit[9][0].get<double>(), -0.01, 2e-4);
    EXPECT_NEAR(hit[9][1].get<double>(), 1, 2e-4);
    EXPECT_NEAR(hit[10][0].get<double>(), -1, 1e-3);
    EXPECT_EQ(miss[2], "separate");
    EXPECT_EQ(miss[3], 1);
    for (int k = 4; k < 11; ++k) EXPECT_TRUE(miss[k].is_null() || k == 6) << miss;
    const std::string csv = folder_.read("r.csv");
    EXPECT_TRUE(
        csv.starts_with("frame,a,b,verdict,gap_bound,stage,kind,max_error,clear_until,contact_by,gap,separating,"
                        "part_a,part_b,x,y,z,normal_x,normal_y,normal_z\n1,wall,hit,colliding,0,exact,,"))
        << csv;
    EXPECT_NE(csv.find("," + hit[3].dump() + "," + hit[4].dump() + ","), std::string::npos) << csv;
    EXPECT_NE(csv.find(",1,,,0,,,,,,,,\n"), std::string::npos) << csv;
}

/// The frame that holds the keys is found at every pace, for every way to write keys.
TEST_F(CommandLine, AContinuousRunPassesTheKeysWithinAFrame)
{
    folder_.write("there_and_back.tum", "0 -5 0 0 0 0 0 1\n10.25 -5 0 0 0 0 0 1\n10.5 5 0 0 0 0 0 1\n"
                                        "10.75 -5 0 0 0 0 0 1\n");
    const double time = 10.25 + 0.25 * (5 - 0.015) / 10;
    for (const std::string motion :
         {R"("keys": [[0, -5, 0, 0, 0, 0, 0, 1], [10.25, -5, 0, 0, 0, 0, 0, 1], [10.5, 5, 0, 0, 0, 0, 0, 1],
                      [10.75, -5, 0, 0, 0, 0, 0, 1]])",
          R"("tum": {"file": "there_and_back.tum", "frames_per_second": 1})"}) {
        folder_.write("scene.json", R"({"frames": 120, "geometries": {
                "wall": {"shape": {"kind": "box", "half": [0.01, 5, 5]}},
                "bullet": {"shape": {"kind": "sphere", "radius": 0.005}}},
            "bodies": [{"geometry": "wall", "static": true},
                       {"geometry": "bullet", "position": [9, 9, 9], "motion": {)" +
                                        motion + "}}]}");
        ASSERT_EQ(run({"run", "scene.json", "--exit-code"}).code, 0);
        for (const double pace : {0.1, 1.0, 4.0, 70.0}) {
            const Outcome outcome = run({"run", "scene.json", "--continuous", "--exit-code", "--pace",
                                         fmt::format("{}", pace), "--csv", "r.csv"});
            EXPECT_EQ(outcome.code, 1) << pace << outcome.err;
            const auto rows = read_csv(folder_.read("r.csv"));
            ASSERT_FALSE(rows.empty()) << pace;
            const double frame = std::stod(rows[0].at("frame")) - 1;
            EXPECT_LE((frame + std::stod(rows[0].at("clear_until"))) * pace, time) << pace;
            EXPECT_GE((frame + std::stod(rows[0].at("contact_by"))) * pace, time) << pace;
        }
    }
}

/// A part of a run, and a run that begins later, write the rows of the whole.
TEST_F(CommandLine, PartsOfAContinuousRunHaveTheRowsOfTheWhole)
{
    const std::vector<std::string> arguments{"run", "many", "--bodies", "60", "--frames", "6", "--continuous"};
    const auto with = [&](std::vector<std::string> more) {
        more.insert(more.begin(), arguments.begin(), arguments.end());
        return run(more).code;
    };
    ASSERT_EQ(with({"--csv", "whole.csv"}), 0);
    ASSERT_EQ(with({"--csv", "a.csv", "--shard", "1/2"}), 0);
    ASSERT_EQ(with({"--csv", "b.csv", "--shard", "2/2"}), 0);
    ASSERT_EQ(run({"merge", "a.csv", "b.csv", "--out", "merged.csv"}).code, 0);
    EXPECT_TRUE(folder_.read("merged.csv") == folder_.read("whole.csv"));
    ASSERT_EQ(with({"--csv", "late.csv", "--from-frame", "3"}), 0);
    const std::string whole = folder_.read("whole.csv"), late = folder_.read("late.csv");
    EXPECT_TRUE(whole.ends_with(late.substr(late.find('\n') + 1)));
    ASSERT_EQ(with({"--csv", "saved.csv", "--checkpoint", "state"}), 0);
    EXPECT_TRUE(folder_.read("saved.csv") == whole);
}

TEST_F(CommandLine, AContinuousRunWithCheckpointsRefusesWhatOneProcessNeeds)
{
    const std::vector<std::string> options[] = {
        {"--pairs", "p.h5"}, {"--from-frame", "1"}, {"--exit-code"}, {"--view", "v.html"}};
    for (const std::vector<std::string>& option : options) {
        std::vector<std::string> arguments{"run", "boxes", "--continuous", "--checkpoint", "state"};
        arguments.insert(arguments.end(), option.begin(), option.end());
        expect_error(64, arguments, {option[0], "single process"});
    }
}

} // namespace
} // namespace oncollide::test
