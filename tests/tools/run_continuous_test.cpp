// oncollide run --continuous.
#include "command_fixture.hpp"

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

} // namespace
} // namespace oncollide::test
