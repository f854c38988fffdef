#include <oncollide/base/error.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/runs/report.hpp>
#include <oncollide/samples/generators.hpp>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace oncollide {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Three boxes in a row, 0.9 m apart at first: the first two overlap, then they separate.
class ReportTest : public ::testing::Test {
protected:
    ReportTest()
    {
        std::string name = (fs::temp_directory_path() / "oncollide-report-XXXXXX").string();
        folder_ = ::mkdtemp(name.data());
        scene_.name = "three \"boxes\" & <more>";
        const GeometryId box = scene_.add("box", Box{{0.5, 0.5, 0.5}});
        const char* names[] = {"plain", "with, comma and \"quotes\"", "line\nbreak and \xff"};
        for (int k = 0; k < 3; ++k) {
            BodyInit body{.name = names[k], .geometry = box};
            body.pose.translation().x() = 0.9 * k;
            scene_.add_body(body);
        }
    }
    ~ReportTest() override { fs::remove_all(folder_); }

    /// Four frames; the last box moves away by 0.2 m per frame.
    void play(Pipeline& pipeline, Report& report)
    {
        for (int frame = 0; frame < 4; ++frame) {
            scene_.set_position(SceneBodyId{2}, {1.8 + 0.2 * frame, 0, 0});
            const FrameView view = pipeline.step(scene_);
            for (const PairResult& pair : view.pairs) ++counts_[int(pair.verdict)];
            bounds_.insert(bounds_.end(), view.pairs.begin(), view.pairs.end());
            hashes_.push_back(view.hash);
            report.add(view);
        }
    }
    std::string read(const std::string& file) const
    {
        std::ifstream stream(folder_ / file);
        return {std::istreambuf_iterator<char>(stream), {}};
    }

    Scene scene_;
    fs::path folder_;
    std::array<std::uint64_t, 4> counts_{};
    std::vector<PairResult> bounds_;
    std::vector<std::uint64_t> hashes_;
};

TEST_F(ReportTest, JsonHoldsEveryPairWithNamesAndBoundsToTheLastBit)
{
    Pipeline pipeline(scene_);
    Report report(scene_, pipeline, {.separate = true});
    play(pipeline, report);
    report.write_json(folder_ / "r.json");
    const json results = json::parse(read("r.json"));
    const json& header = results.at("header");
    EXPECT_EQ(header.at("version"), version);
    EXPECT_EQ(header.at("scene"), scene_.name);
    EXPECT_EQ(header.at("bodies"), 3);
    EXPECT_EQ(header.at("frames"), 4);
    EXPECT_EQ(header.at("interrupted"), false);
    EXPECT_EQ(header.at("hash"), fmt::format("{:016x}", pipeline.hash()));
    for (int k = 0; k < 4; ++k) EXPECT_EQ(header.at("verdicts").at(std::string(name_of(Verdict(k)))), counts_[k]);

    std::size_t at = 0;
    for (std::size_t frame = 0; frame < 4; ++frame) {
        EXPECT_EQ(results.at("frames").at(frame).at("frame"), frame);
        EXPECT_EQ(results.at("frames").at(frame).at("hash"), fmt::format("{:016x}", hashes_[frame]));
        for (const json& pair : results.at("frames").at(frame).at("pairs")) {
            ASSERT_LT(at, bounds_.size());
            const PairResult& expected = bounds_[at++];
            // A byte that is not UTF-8 becomes U+FFFD.
            EXPECT_EQ(pair.at(1), index(expected.b) < 2 ? std::string(scene_.names[index(expected.b)])
                                                        : "line\nbreak and \xef\xbf\xbd");
            EXPECT_EQ(pair.at(2), name_of(expected.verdict));
            EXPECT_EQ(pair.at(3).get<double>(), expected.bound);
            EXPECT_EQ(pair.at(4), name_of(expected.stage));
            EXPECT_TRUE(pair.at(5).is_null()) << "kinds were not requested";
        }
    }
    EXPECT_EQ(at, bounds_.size());
    EXPECT_EQ(results.at("stages").size(), pipeline.inspect().totals.size());
    EXPECT_EQ(results.at("stages").at(2).at("stage"), "broad");
}

TEST_F(ReportTest, SeparatePairsAreCountedButKeptOnlyOnRequest)
{
    Pipeline pipeline(scene_);
    Report report(scene_, pipeline);
    play(pipeline, report);
    report.write_json(folder_ / "r.json");
    const json results = json::parse(read("r.json"));
    std::size_t kept = 0;
    for (const json& frame : results.at("frames"))
        for (const json& pair : frame.at("pairs")) {
            ++kept;
            EXPECT_NE(pair.at(2), "separate");
        }
    EXPECT_EQ(kept, bounds_.size() - counts_[int(Verdict::separate)]);
    EXPECT_EQ(results.at("header").at("verdicts").at("separate"), counts_[int(Verdict::separate)]);
    EXPECT_EQ(report.verdicts(), counts_);
}

TEST_F(ReportTest, SettingsAndInterruptionAreInTheHeader)
{
    Settings settings;
    settings.max_error = 0.1;
    settings.clearance = 0.25;
    settings.skip = {StageId::delimitation};
    settings.exact = ExactLevel::fcl;
    Pipeline pipeline(scene_, settings);
    Report report(scene_, pipeline);
    play(pipeline, report);
    report.interrupted();
    report.write_json(folder_ / "r.json");
    const json header = json::parse(read("r.json")).at("header");
    EXPECT_EQ(header.at("interrupted"), true);
    EXPECT_TRUE(header.at("settings").at("depth").is_null());
    EXPECT_EQ(header.at("settings").at("max_error"), 0.1);
    EXPECT_EQ(header.at("settings").at("clearance"), 0.25);
    EXPECT_EQ(header.at("settings").at("exact"), "fcl");
    EXPECT_EQ(header.at("settings").at("skip"), json::array({"delimitation"}));
}

TEST_F(ReportTest, CsvQuotesNamesAsRfc4180Asks)
{
    Pipeline pipeline(scene_);
    Report report(scene_, pipeline, {.separate = true});
    play(pipeline, report);
    report.write_csv(folder_ / "r.csv");
    const std::string text = read("r.csv");
    EXPECT_TRUE(text.starts_with(
        "frame,a,b,verdict,gap_bound,stage,kind,max_error\n0,plain,\"with, comma and \"\"quotes\"\"\","))
        << text;
    EXPECT_NE(text.find(",\"line\nbreak and \xEF\xBF\xBD\","), std::string::npos) << text;
    // One row per pair, one header, and one more line per row with the name that contains a line break.
    std::size_t rows = 1 + bounds_.size();
    for (const PairResult& pair : bounds_) rows += index(pair.b) == 2;
    EXPECT_EQ(std::size_t(std::count(text.begin(), text.end(), '\n')), rows);
}

TEST_F(ReportTest, HoldsTheKindOfEveryContact)
{
    Scene scene;
    const GeometryId box = scene.add("box", make_box_mesh({0.5, 0.5, 0.5}));
    for (const double x : {0.0, 1.0, 1.9, 3.0}) { // face on face; overlapping; near
        const SceneBodyId body = scene.add_body({.name = std::to_string(x), .geometry = box});
        scene.set_position(body, Eigen::Vector3d(x, x == 1.9 ? 0.25 : 0, x == 1.9 ? 0.1 : 0));
    }
    Pipeline pipeline(scene, {.clearance = 0.2, .exact = ExactLevel::predicates, .contact_kinds = true});
    Report report(scene, pipeline);
    report.add(pipeline.step(scene));
    EXPECT_EQ(report.kinds(), (std::array<std::uint64_t, 5>{0, 1, 1, 1, 0}));
    report.write_json(folder_ / "r.json"), report.write_csv(folder_ / "r.csv");
    const json results = json::parse(read("r.json"));
    EXPECT_EQ(results.at("header").at("kinds"), (json{{"near", 1}, {"touching", 1}, {"crossing", 1}, {"enclosed", 0}}));
    const json& pairs = results.at("frames").at(0).at("pairs");
    ASSERT_EQ(pairs.size(), 3u);
    const char* kinds[] = {"touching", "crossing", "near"};
    std::istringstream rows(read("r.csv"));
    std::string row;
    std::getline(rows, row);
    for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_EQ(pairs.at(k).at(5), kinds[k]);
        std::getline(rows, row);
        EXPECT_NE(row.find(std::string(",exact,") + kinds[k] + ",0.01732"), std::string::npos) << row;
        EXPECT_DOUBLE_EQ(pairs.at(k).at(6).get<double>(), 0.01 * std::sqrt(3.0));
    }
    std::ostringstream table;
    report.print_table(table);
    EXPECT_NE(table.str().find("1 touching, 1 crossing, 0 enclosed, 1 near"), std::string::npos);
}

TEST_F(ReportTest, TraceNestsStagesInFramesWithoutOverlap)
{
    Pipeline pipeline(scene_);
    Report report(scene_, pipeline);
    play(pipeline, report);
    report.write_trace(folder_ / "t.json");
    double frame_end = 0, stage_end = 0;
    int frames = 0, stages = 0, counters = 0;
    constexpr double tolerance = 2e-3; // microseconds are written with three decimals
    const json trace = json::parse(read("t.json"));
    for (const json& event : trace.at("traceEvents")) {
        counters += event.at("ph") == "C";
        if (event.at("ph") != "X" || event.at("tid") != 1) continue;
        const double begin = event.at("ts"), end = begin + event.at("dur").get<double>();
        if (event.at("name").get<std::string>().starts_with("frame")) {
            EXPECT_GE(begin, frame_end - tolerance);
            frame_end = end, stage_end = begin, ++frames;
        } else {
            EXPECT_GE(begin, stage_end - tolerance);
            EXPECT_LE(end, frame_end + 5 * tolerance);
            stage_end = end, ++stages;
        }
    }
    EXPECT_EQ(frames, 4);
    EXPECT_EQ(stages, 4 * 5);
    EXPECT_EQ(counters, 4 * 2);
}

TEST_F(ReportTest, TraceHasATrackOfRounds)
{
    Pipeline pipeline(scene_, {.depth = 4, .backend = BackendKind::gl_compute});
    Report report(scene_, pipeline);
    play(pipeline, report);
    report.write_trace(folder_ / "t.json");
    std::size_t rounds = 0;
    double end = 0;
    const json trace = json::parse(read("t.json"));
    for (const json& event : trace.at("traceEvents")) {
        if (event.at("ph") != "X" || event.at("tid") != 2) continue;
        EXPECT_GE(event.at("ts").get<double>(), end - 2e-3) << "one after the other";
        end = event.at("ts").get<double>() + event.at("dur").get<double>();
        EXPECT_GT(event.at("args").at("rows"), 0);
        EXPECT_GT(event.at("args").at("gpu_ms"), 0);
        ++rounds;
    }
    EXPECT_GT(rounds, 2u);
}

TEST_F(ReportTest, TableAndPictureNameEveryStageAndTheHash)
{
    Pipeline pipeline(scene_);
    Report report(scene_, pipeline);
    play(pipeline, report);
    std::ostringstream table;
    report.print_table(table);
    report.write_picture(folder_ / "p.svg");
    const std::string picture = read("p.svg");
    for (std::string_view stage : pipeline.stages()) {
        EXPECT_NE(table.str().find(stage), std::string::npos) << stage;
        EXPECT_NE(picture.find(">" + std::string(stage) + "<"), std::string::npos) << stage;
    }
    EXPECT_NE(table.str().find(fmt::format("{:016x}", pipeline.hash())), std::string::npos);
    EXPECT_NE(picture.find("&amp; &lt;more&gt;"), std::string::npos);
    EXPECT_TRUE(picture.ends_with("</svg>\n"));
    EXPECT_EQ(picture.find("nan"), std::string::npos);
}

TEST_F(ReportTest, ColumnsOfTheTableStayApartAboveTenToTheNinth)
{
    Scene many; // far apart, in a line
    const GeometryId box = many.add("box", Box{{0.5, 0.5, 0.5}});
    for (int k = 0; k < 100'000; ++k) {
        BodyInit body{.name = fmt::format("{}", k), .geometry = box};
        body.pose.translation().x() = 10 * k;
        many.add_body(body);
    }
    Pipeline pipeline(many, {.skip = {StageId::delimitation}});
    Report report(many, pipeline);
    report.add(pipeline.step(many));
    std::ostringstream table;
    report.print_table(table);
    EXPECT_NE(table.str().find(" 4,999,950,000          0 4,999,950,000 "), std::string::npos) << table.str();
}

TEST_F(ReportTest, NoFramesStillGiveValidFiles)
{
    Pipeline pipeline(scene_);
    Report report(scene_, pipeline);
    report.write_json(folder_ / "r.json");
    report.write_trace(folder_ / "t.json");
    report.write_csv(folder_ / "r.csv");
    report.write_picture(folder_ / "p.svg");
    EXPECT_TRUE(json::parse(read("r.json")).at("frames").empty());
    EXPECT_TRUE(json::accept(read("t.json")));
    EXPECT_EQ(read("p.svg").find("nan"), std::string::npos);
    std::ostringstream table;
    report.print_table(table);
    EXPECT_EQ(table.str().find("nan"), std::string::npos);
}

TEST_F(ReportTest, FailedWritesNameThePathAndLeaveTheOldFileAlone)
{
    Pipeline pipeline(scene_);
    Report report(scene_, pipeline);
    play(pipeline, report);
    for (const std::string& bad : {(folder_ / "no" / "r.json").string(), folder_.string(), std::string("/dev/full")}) {
        try {
            report.write_json(bad);
            ADD_FAILURE() << bad << " was written";
        } catch (const Error& error) {
            EXPECT_EQ(error.kind(), ErrorKind::cannot_write);
            EXPECT_TRUE(std::string(error.what()).starts_with(bad)) << error.what();
        }
    }
    EXPECT_TRUE(fs::is_empty(folder_));
    EXPECT_TRUE(fs::is_character_file("/dev/full"));

    std::ofstream(folder_ / "old.json") << "old";
    EXPECT_NO_THROW(check_writable(folder_ / "old.json"));
    EXPECT_NO_THROW(check_writable(folder_ / "new.json"));
    EXPECT_EQ(read("old.json"), "old");
    EXPECT_FALSE(fs::exists(folder_ / "new.json"));
    report.write_json(folder_ / "old.json");
    EXPECT_TRUE(json::accept(read("old.json")));
}

} // namespace
} // namespace oncollide
