// The contents of the page of 'run --view' and 'view'.
#include "tools/view_fixture.hpp"

namespace oncollide::test {
namespace {

TEST_F(View, ThePageHoldsTheFramesOfTheRun)
{
    write_scene("scene.json", 1.5);
    const Outcome outcome = run_without_three(
        {"run", "scene.json", "--exact", "predicates", "--separate", "--view", "x.html", "--json", "r.json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("x.html: "), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("8 frames"), std::string::npos) << outcome.err;

    const nlohmann::json h = header(), results = read_json("r.json");
    ASSERT_EQ(run({"run", "scene.json", "--exact", "predicates", "--quiet", "--json", "same.json"}).code, 0);
    EXPECT_EQ(results.at("header").at("hash"), read_json("same.json").at("header").at("hash"));
    EXPECT_EQ(h.at("bodies"), 2);
    EXPECT_EQ(h.at("names"), (nlohmann::json{"one", "other"}));
    EXPECT_EQ(h.at("moving"), 1);
    ASSERT_EQ(h.at("frames").size(), 8u);
    EXPECT_EQ(h.at("notes"), nlohmann::json::array());
    std::size_t colliding = 0, meeting = 0;
    for (std::size_t f = 0; f < 8; ++f) {
        const nlohmann::json &shown = h.at("frames")[f], &frame = results.at("frames")[f];
        EXPECT_EQ(shown.at("hash"), frame.at("hash"));
        const nlohmann::json& counts = frame.at("verdicts");
        EXPECT_EQ(shown.at("verdicts"),
                  (nlohmann::json{counts["separate"], counts["within"], counts["colliding"], counts["undecided"]}));
        EXPECT_EQ(shown.at("pairs"), frame.at("pairs").size());
        colliding += counts["colliding"].get<std::size_t>(), meeting += shown.at("curve").get<std::size_t>();
        // Poses are relative to the origin of the page.
        const std::vector<float> position = floats(fmt::format("f{}", f), 0, 3);
        EXPECT_NEAR(position[0] + h.at("origin")[0].get<double>(), 1.5 - 0.1 * double(f), 1e-6) << f;
        EXPECT_NEAR(position[1] + h.at("origin")[1].get<double>(), 0.1, 1e-6);
        if (frame.at("pairs").empty()) continue;
        // Rounding keeps bounds certified.
        const nlohmann::json& pair = frame.at("pairs")[0];
        const double bound = pair[3], kept = floats(fmt::format("f{}", f), 5, 1)[0];
        EXPECT_TRUE(pair[2] == "separate" ? kept <= bound : kept >= bound) << pair;
        EXPECT_NEAR(kept, bound, 1e-6);
    }
    EXPECT_GT(colliding, 0u);
    EXPECT_GT(meeting, 10u) << "where the surfaces meet";
}

TEST_F(View, ThePageNeedsNothingElse)
{
    ASSERT_EQ(run_without_three({"run", "city", "--bodies", "40", "--frames", "3", "--quiet", "--view", "x.html"}).err,
              "");
    const std::string page = folder_.read("x.html");
    for (const char* outside : {"http://", "https://", " src=", " href=", "@import", "url("})
        EXPECT_EQ(page.find(outside), std::string::npos) << outside;
    EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
    EXPECT_EQ(page.find("three </script>"), std::string::npos) << "the embedded text ends no element";
    EXPECT_NE(page.find("three <\\/script>"), std::string::npos);
}

TEST_F(View, RegionsAreThoseThatTheLevelsCount)
{
    ASSERT_EQ(
        run_without_three({"run", "city", "--bodies", "300", "--frames", "5", "--quiet", "--view", "x.html"}).code, 0);
    std::size_t all = 0;
    const nlohmann::json h = header();
    for (const nlohmann::json& frame : h.at("frames")) {
        std::size_t counted = 0;
        for (const nlohmann::json& level : frame.at("levels")) counted += level[0].get<std::size_t>();
        EXPECT_EQ(frame.at("regions"), counted) << frame;
        all += counted;
    }
    EXPECT_GT(all, 10u);
}

TEST_F(View, NamesAreTextAndNothingElse)
{
    const std::string name = "</script><script>document.title='owned'</script><!--<script><img src=x onerror=alert(1)>";
    write_scene("scene.json", 0.8, name);
    ASSERT_EQ(run_without_three({"run", "scene.json", "--quiet", "--view", "x.html"}).code, 0);
    EXPECT_EQ(header().at("names")[1], name);
    const std::string page = folder_.read("x.html");
    EXPECT_EQ(page.find("owned'</script>"), std::string::npos);
    EXPECT_EQ(page.find("<img"), std::string::npos);
    EXPECT_EQ(page.find("<!--<script"), std::string::npos);
}

TEST_F(View, JsonHoldsNumbersAlone)
{
    write_scene("scene.json", 0.9);
    ASSERT_EQ(
        run_without_three({"run", "scene.json", "--quiet", "--node-budget", "1", "--depth", "8", "--view", "x.html"})
            .code,
        0);
    const std::string text = block("header");
    for (const char* none : {"NaN", "nan", "Infinity", "inf,", "inf]"})
        EXPECT_EQ(text.find(none), std::string::npos) << none;
}

TEST_F(View, ALimitThinsOutAndSaysSo)
{
    const Outcome outcome = run_without_three({"run", "boxes", "--bodies", "1900", "--frames", "40", "--skip", "refine",
                                               "--view", "x.html", "--view-limit", "2"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("frames (one in "), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("--view-limit allows 2.0 MB"), std::string::npos) << outcome.err;
    EXPECT_LT(folder_.read("x.html").size(), 2'000'000u);
    const nlohmann::json h = header();
    EXPECT_EQ(h.at("frames_run"), 40);
    ASSERT_GT(h.at("frames").size(), 1u);
    EXPECT_LT(h.at("frames").size(), 40u);
    EXPECT_NE(h.at("notes").dump().find("one frame in"), std::string::npos);
    const int step = h.at("frames")[1].at("frame");
    for (std::size_t k = 0; k < h.at("frames").size(); ++k) EXPECT_EQ(h.at("frames")[k].at("frame"), step * int(k));

    expect_error(
        64, {"run", "many", "--bodies", "100000", "--frames", "1", "--quiet", "--view", "y.html", "--view-limit", "2"},
        {"--view-limit", "100,000 bodies", "or more"});
}

/// Rows of three overlapping balls: more pairs than fit, then a limit with room for all of them.
TEST_F(View, PairsThatDoNotFitAreCountedAndTheirBodiesKeepTheirColours)
{
    constexpr int rows = 11'000;
    std::string bodies;
    for (int row = 0; row < rows; ++row)
        for (const double x : {0.0, 0.8, 1.6})
            bodies += fmt::format(R"(,{{"geometry": "ball", "position": [{}, {}, {}]}})", x + 4 * (row % 20),
                                  2 * (row / 20 % 20), 2 * (row / 400));
    folder_.write("balls.json",
                  R"({"geometries": {"ball": {"shape": {"kind": "sphere", "radius": 0.5}}}, "bodies": [)" +
                      bodies.substr(1) + R"(, {"geometry": "ball", "position": [-9, 0, 0]}]})");
    const auto page = [&](const char* limit) {
        const Outcome outcome = run_without_three({"run", "balls.json", "--view", "x.html", "--view-limit", limit});
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        return outcome.err;
    };
    const std::string few = page("2"), left_out = " of 22,000 pairs of frame 0 are left out";
    EXPECT_NE(few.find(left_out), std::string::npos) << few;
    EXPECT_NE(few.find("--view-limit allows 2.0 MB"), std::string::npos) << few;
    const std::size_t size = folder_.read("x.html").size();
    EXPECT_LT(size, 2'000'000u);
    EXPECT_GT(size, 1'400'000u) << "the page uses its room";
    const nlohmann::json h = header(), frame = h.at("frames")[0];
    const std::size_t pairs = frame.at("pairs"), lacking = frame.at("left_out");
    EXPECT_EQ(pairs + lacking, 22'000u);
    EXPECT_GT(pairs, 1000u);
    EXPECT_GT(lacking, 1000u);
    EXPECT_NE(h.at("notes").dump().find(left_out), std::string::npos) << h.at("notes");
    // The last bytes of the frame: the rank of each body's worst pair.
    const std::string bytes = decoded_base64(block("f0")), ranks = bytes.substr(bytes.size() - 3 * rows - 1);
    EXPECT_EQ(ranks, std::string(3 * rows, '\4') + '\0') << "all bodies collide, except the last one";

    const std::string all = page("4");
    EXPECT_EQ(all.find("left out"), std::string::npos) << all;
    EXPECT_EQ(header().at("frames")[0].at("pairs"), 22'000);
    EXPECT_EQ(header().at("frames")[0].at("left_out"), 0);
    EXPECT_EQ(header().at("notes"), nlohmann::json::array());
}

TEST_F(View, LargeMeshesAreSimplified)
{
    folder_.write("scene.json", R"({"geometries": {"ball": {"mesh": {"generate": {"kind": "sphere", "radius": 0.5,
        "triangles": 500000}}}}, "bodies": [{"geometry": "ball"}, {"geometry": "ball", "position": [0.5, 0, 0]}]})");
    const Outcome outcome = run_without_three({"run", "scene.json", "--view", "x.html", "--view-limit", "3"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("1 geometry shown simplified"), std::string::npos) << outcome.err;
    EXPECT_LT(folder_.read("x.html").size(), 3'000'000u);
    const nlohmann::json geometry = header().at("geometries")[0];
    EXPECT_GT(geometry.at("triangles"), 400'000);
    EXPECT_LT(geometry.at("meshes")[0][1], 300'000);
    EXPECT_GT(geometry.at("meshes")[0][1], 1'000);
}

TEST_F(View, EveryKindOfGeometryIsShown)
{
    folder_.write("kinds.json", R"({"geometries": {"pill": {"shape": {"kind": "capsule", "radius": 0.3, "length": 1}},
        "floor": {"shape": {"kind": "half_space"}}, "hills": {"terrain": {"hills": {"cells": [200, 100], "spacing": 0.1, "height": 1, "seed": 3}}},
        "house": {"octomap": {"building": {"rooms": 1, "resolution": 0.25, "seed": 7}}}},
        "bodies": [{"name": "pill", "geometry": "pill"}, {"name": "house", "geometry": "house"},
                   {"name": "floor", "geometry": "floor", "static": true}, {"name": "hills", "geometry": "hills"}]})");
    const Outcome outcome = run_without_three({"run", "kinds.json", "--quiet", "--view", "x.html"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const nlohmann::json geometries = header().at("geometries");
    ASSERT_EQ(geometries.size(), 4u);
    for (const nlohmann::json& g : geometries) {
        EXPECT_GT(g.at("meshes")[0][1], 1) << g;
        for (int axis = 0; axis < 3; ++axis) EXPECT_LE(g.at("low")[axis], g.at("high")[axis]);
    }
}

class ViewOfResults : public View {
protected:
    void SetUp() override
    {
        if (run({"run", "city", "--bodies", "5", "--frames", "1", "--quiet", "--pairs", "p.h5"}).code)
            GTEST_SKIP() << "skipped: no HDF5";
        write_stand_in();
        ::setenv("ONCOLLIDE_THREE", (folder_ / "lib").c_str(), 1);
    }
    void TearDown() override { ::unsetenv("ONCOLLIDE_THREE"); }
    std::string without_about(nlohmann::json header)
    {
        header.erase("about");
        return header.dump();
    }
};

TEST_F(ViewOfResults, IsThePageOfTheRun)
{
    write_scene("scene.json", 1.2);
    const std::vector<std::vector<std::string>> runs{
        {"city", "--bodies", "300", "--seed", "5", "--frames", "6", "--pace", "2", "--clearance", "0.1"},
        {"scene.json", "--exact", "predicates", "--separate"},
        {"scene.json", "--exact", "predicates", "--continuous"},
        {"city", "--bodies", "100", "--frames", "6", "--pace", "9", "--continuous", "--from-frame", "2"},
        {"scene.json", "--mode", "solid", "--exact", "predicates", "--kinds", "--from-frame", "3"}};
    for (const std::vector<std::string>& options : runs) {
        std::vector<std::string> arguments{"run", "--quiet", "--pairs", "p.h5", "--view", "x.html"};
        arguments.insert(arguments.end(), options.begin(), options.end());
        std::filesystem::remove(folder_ / "p.h5");
        ASSERT_EQ(run(arguments).err, "");
        const Outcome outcome = run({"view", "p.h5", "-o", "y.html"});
        ASSERT_EQ(outcome.code, 0) << outcome.err;
        EXPECT_NE(outcome.err.find("y.html: "), std::string::npos) << outcome.err;
        const nlohmann::json ran = header(), read = header("y.html");
        EXPECT_EQ(without_about(read), without_about(ran));
        for (std::size_t f = 0; f < ran.at("frames").size(); ++f)
            EXPECT_EQ(block(fmt::format("f{}", f), "y.html"), block(fmt::format("f{}", f))) << f;
        EXPECT_NE(read.at("about").dump().find("p.h5"), std::string::npos);
        EXPECT_EQ(read.at("about").back(), ran.at("about").back());
    }
}

TEST_F(ViewOfResults, ShowsTheFramesThatAreRequested)
{
    write_scene("scene.json", 1.2);
    ASSERT_EQ(run({"run", "scene.json", "--quiet", "--pairs", "p.h5"}).code, 0);
    ASSERT_EQ(run({"view", "p.h5", "-o", "x.html", "--from-frame", "2", "--to-frame", "4"}).code, 0);
    const nlohmann::json frames = header().at("frames");
    ASSERT_EQ(frames.size(), 3u);
    EXPECT_EQ(frames[0].at("frame"), 2);
    EXPECT_EQ(frames[2].at("frame"), 4);

    const std::vector<std::string> view{"view", "p.h5", "-o", "y.html"};
    const auto with = [&](std::vector<std::string> more) {
        more.insert(more.begin(), view.begin(), view.end());
        return more;
    };
    expect_error(64, with({"--to-frame", "8"}), {"--to-frame 8", "p.h5", "0 to 7"});
    expect_error(64, with({"--from-frame", "-1"}), {"--from-frame -1", "0 to 7"});
    expect_error(64, with({"--from-frame", "5", "--to-frame", "3"}), {"--from-frame 5"});
}

TEST_F(ViewOfResults, BelongToTheirScene)
{
    write_scene("scene.json", 1.2);
    ASSERT_EQ(run({"run", "scene.json", "--quiet", "--pairs", "p.h5"}).code, 0);
    const std::vector<std::string> as_named{"view", "p.h5", "-o", "y.html"};
    write_scene("moved.json", 2.2), write_scene("renamed.json", 1.2, "somebody");
    folder_.write("short.json", R"({"frames": 3, "geometries": {"b": {"shape": {"kind": "sphere", "radius": 0.5}}},
        "bodies": [{"name": "one", "geometry": "b"}, {"name": "other", "geometry": "b"}]})");
    const auto of = [](const char* scene) { return std::vector<std::string>{"view", "p.h5", scene, "-o", "y.html"}; };
    expect_error(65, of("moved.json"), {"p.h5", "does not fit moved.json", "frame"});
    expect_error(65, of("renamed.json"), {"p.h5", "does not fit renamed.json", "'other'"});
    expect_error(65, of("short.json"), {"p.h5", "frames 0 to 2", "frame 7"});
    expect_error(65, of("city"), {"p.h5", "does not fit city", "bodies, the results have 2"});
    std::filesystem::rename(folder_ / "scene.json", folder_ / "elsewhere.json");
    expect_error(66, as_named, {"scene.json", "p.h5 was made from that scene", "has moved"});
    EXPECT_EQ(run(of("elsewhere.json")).code, 0);
}

TEST_F(ViewOfResults, ThatCannotBeReadAreRefused)
{
    ASSERT_EQ(
        run({"run", "city", "--bodies", "40", "--frames", "40", "--quiet", "--json", "r.json", "--pairs", "p.h5"}).code,
        0);
    const auto of = [](const char* file) { return std::vector<std::string>{"view", file, "-o", "y.html"}; };
    expect_error(66, of("missing.h5"), {"missing.h5"});
    expect_error(65, of("r.json"), {"r.json", "not a results file", "--pairs"});
    expect_error(64, {"view", "p.h5", "-o", "p.h5"}, {"--out p.h5", "input"});
    expect_error(64, {"view", "p.h5", "-o", "-"}, {"--out", "standard output"});
    expect_error(64, {"view", "p.h5"}, {"--out"});
    expect_error(73, {"view", "p.h5", "-o", "missing/y.html"}, {"missing/y.html"});
    const std::string whole = folder_.read("p.h5");
    for (const double part : {0.02, 0.1, 0.5, 0.9}) { // hashes detect damage that HDF5 does not
        folder_.write("cut.h5", whole.substr(0, std::size_t(part * double(whole.size()))));
        expect_error(65, of("cut.h5"), {"cut.h5", "damaged"});
    }
    write_scene("scene.json", 1.2);
    ASSERT_EQ(run({"run", "scene.json", "--exact", "off", "--quiet", "--pairs", "p.h5"}).code, 0);
    const std::string sound = folder_.read("p.h5");
    const std::size_t row =
        sound.find(std::string("\0\0\0\0\1\0\0\0\1\3", 10)); // bodies 0 and 1, within, by refinement
    ASSERT_NE(row, std::string::npos);
    for (const auto& [byte, fault] : {std::pair(12, "hash differs"), std::pair(4, "boxes are apart")}) {
        std::string damaged = sound;
        damaged[row + std::size_t(byte)] ^= 2;
        folder_.write("p.h5", damaged);
        expect_error(65, of("p.h5"), {"p.h5", fault});
    }
    const std::size_t header = sound.rfind("OHDR"); // of a dataset, with a checksum
    ASSERT_NE(header, std::string::npos);
    std::string damaged = sound;
    damaged[header + 20] ^= 2;
    folder_.write("p.h5", damaged);
    expect_error(65, of("p.h5"), {"p.h5", "damaged"}); // HDF5 must not try to read it for minutes
    EXPECT_FALSE(std::filesystem::exists(folder_ / "y.html"));
}

TEST_F(View, BadRequestsAreRefusedBeforeTheRun)
{
    write_scene("scene.json", 2);
    expect_error(64, {"run", "scene.json", "--view", ""}, {"--view", "empty"});
    expect_error(64, {"run", "scene.json", "--view", "-"}, {"--view", "standard output"});
    expect_error(64, {"run", "scene.json", "--view", "x.html", "--view-limit", "1"}, {"--view-limit"});
    expect_error(64, {"run", "scene.json", "--view", "scene.json"}, {"--view scene.json", "input"});
    expect_error(64, {"run", "scene.json", "--view", "x.html", "--json", "x.html"}, {"--view", "--json"});
    expect_error(64, {"run", "scene.json", "--view-limit", "20"}, {"--view-limit", "--view"});
    expect_error(73, {"run", "scene.json", "--view", "missing/x.html"}, {"missing/x.html"});
    Surroundings nothing;
    nothing.environment.emplace_back("ONCOLLIDE_THREE", folder_.path().string());
    const Outcome outcome = run({"run", "scene.json", "--view", "x.html"}, nothing);
    EXPECT_EQ(outcome.code, 66);
    EXPECT_EQ(outcome.out, "");
    EXPECT_NE(outcome.err.find("libjs-three"), std::string::npos) << outcome.err;
    EXPECT_EQ(folder_.list(), (std::vector<std::string>{"scene.json"}));
}

} // namespace
} // namespace oncollide::test
