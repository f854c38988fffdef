// oncollide accuracy continuous.
#include "tools/command/study/study_fixture.hpp"
#include "tools/decoded_png.hpp"

namespace oncollide::test {
namespace {

class ContinuousStudy : public Study {
protected:
    /// Two thin plates in the way of small cubes, which pass them in the middle of a frame and, one of them, beside
    /// them.
    void SetUp() override
    {
        std::string bodies =
            R"({"name": "near", "geometry": "plate"}, {"name": "far", "geometry": "plate", "position": [4.2, 0, 0]})";
        for (int k = 0; k < 5; ++k)
            bodies += fmt::format(
                R"(, {{"name": "cube {0}", "geometry": "cube", "position": [-1.37, {1}, 0.1], "motion": {{"drift": {{"velocity": [{2}, 0, 0]}}}}}})",
                k, k == 4 ? 1.2 : 0.4 * k - 0.6, 3 + 0.1 * k);
        folder_.write("plates.json",
                      R"({"frames": 3, "geometries": {
                          "plate": {"mesh": {"generate": {"kind": "box", "half": [0.001, 1, 1]}}},
                          "cube": {"mesh": {"generate": {"kind": "box", "half": [0.05, 0.05, 0.05]}}}}, "bodies": [)" +
                          bodies + "]}");
    }
    static nlohmann::json row(const nlohmann::json& study, const std::string& setting)
    {
        for (const nlohmann::json& one : study.at("rows"))
            if (one.at("setting") == setting) return one;
        ADD_FAILURE() << "no row " << setting << " in " << study;
        return {};
    }
};

TEST_F(ContinuousStudy, CountsWhatSampledPosesMissAndShowsTheWorst)
{
    const Outcome outcome = run({"accuracy", "continuous", "plates.json", "--poses", "1,10,1000", "--json", "s.json",
                                 "--csv", "s.csv", "--html", "s.html"});
    ASSERT_EQ(outcome.code, 0) << outcome.out << outcome.err;
    const nlohmann::json study = read_json("s.json");
    EXPECT_EQ(study.at("schema"), "oncollide.accuracy_continuous");
    const std::uint64_t contacts = study.at("header").at("contacts");
    EXPECT_EQ(contacts, 8u) << "four cubes and two plates";
    EXPECT_EQ(study["header"]["contradicted"], 0);
    for (const char* tolerance : {"tolerance 0.01", "tolerance 0.001", "tolerance 0.0001", "tolerance 1e-06"}) {
        EXPECT_EQ(row(study, tolerance).at("contacts"), contacts);
        EXPECT_EQ(row(study, tolerance).at("missed"), 0);
        EXPECT_EQ(row(study, tolerance).at("invented"), 0);
    }
    EXPECT_EQ(row(study, "1 pose a step").at("missed"), contacts);
    EXPECT_GT(row(study, "10 poses a step").at("missed"), 0);
    EXPECT_EQ(row(study, "1000 poses a step").at("missed"), 0) << "a step of 3.4 mm; the cubes are 100 mm wide";
    EXPECT_LE(row(study, "tolerance 0.0001").at("latest"), 1e-4);
    EXPECT_LE(row(study, "1000 poses a step").at("latest"), 1e-3);
    EXPECT_EQ(row(study, "default: sampled").at("steps"), study["header"]["studied"]);
    EXPECT_EQ(std::ranges::count(folder_.read("s.csv"), '\n'), 10);

    const std::string page = folder_.read("s.html"), from = "data:image/png;base64,";
    EXPECT_NE(page.find("apart in all 10 sampled poses"), std::string::npos);
    EXPECT_EQ(count_of(page, from), 1u);
    EXPECT_EQ(count_of(page, "<svg"), 1u);
    EXPECT_EQ(page.find("FAULT"), std::string::npos);
}

TEST_F(ContinuousStudy, ASceneWithoutContactsSaysSoAndNamesOthers)
{
    folder_.write("by.json", R"({"frames": 3, "geometries": {"ball": {"mesh": {"generate": {"kind": "sphere",
        "radius": 0.5, "triangles": 512}}}}, "bodies": [{"geometry": "ball"}, {"geometry": "ball",
        "position": [0.75, 0.75, 0], "motion": {"drift": {"velocity": [0.01, 0, 0]}}}]})");
    const std::vector<std::string> command{"accuracy", "continuous", "by.json", "--html", "s.html", "--svg", "s.svg"};
    const Outcome none = run(command);
    ASSERT_EQ(none.code, 0) << none.err;
    for (const std::string& text : {none.out, folder_.read("s.html")})
        EXPECT_NE(text.find("No pair meets on its way"), std::string::npos) << text;
    EXPECT_NE(none.out.find("octomap"), std::string::npos) << none.out;
    EXPECT_TRUE(folder_.read("s.svg").starts_with("<svg "));
    EXPECT_EQ(run({"accuracy", "continuous", "plates.json"}).out.find("No pair meets"), std::string::npos);
}

TEST_F(ContinuousStudy, RefusesNonsense)
{
    expect_error(64, {"accuracy", "continuous", "plates.json", "--tolerances", "0"}, {"--tolerances", "1e-12"});
    expect_error(64, {"accuracy", "continuous", "plates.json", "--tolerances", "x"}, {"--tolerances", "x"});
    expect_error(64, {"accuracy", "continuous", "plates.json", "--poses", "0"}, {"--poses"});
    expect_error(64, {"accuracy", "continuous", "plates.json", "--frames", "1"}, {"at least 2 frames"});
    expect_error(66, {"accuracy", "continuous", "none.json"}, {"none.json"});
}

} // namespace
} // namespace oncollide::test
