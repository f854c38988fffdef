// The page of 'run --view' and 'view': its contents are read back and, if Chromium and three.js are installed, it is
// rendered.
#include "browser.hpp"
#include "command_fixture.hpp"
#include "decoded_png.hpp"

#include <cmath>
#include <cstring>

namespace oncollide::test {
namespace {

const char* const three = "/usr/share/javascript/three/three.min.js";

std::string decoded_base64(std::string_view text)
{
    constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string bytes;
    unsigned group = 0, bits = 0;
    for (const char c : text) {
        if (c == '=') break;
        group = group << 6 | unsigned(digits.find(c)), bits += 6;
        if (bits >= 8) bits -= 8, bytes += char(group >> bits & 255);
    }
    return bytes;
}

class View : public CommandLine {
protected:
    /// Two spheres of radius 0.5, the second moving by -0.1 m per frame, initially `distance` away.
    void write_scene(const std::string& name, double distance, const std::string& second = "other")
    {
        const nlohmann::json body = second;
        folder_.write(name, fmt::format(R"({{"frames": 8, "geometries": {{"ball": {{"mesh": {{"generate":
            {{"kind": "sphere", "radius": 0.5, "triangles": 512}}}}}}}},
            "bodies": [{{"name": "one", "geometry": "ball", "static": true}}, {{"name": {}, "geometry": "ball",
            "position": [{}, 0.1, 0.05], "motion": {{"drift": {{"velocity": [-0.1, 0, 0]}}}}}}]}})",
                                        body.dump(), distance));
    }

    /// Runs with a mock of three.js, so that tests of the page's contents do not need three.js.
    void write_stand_in()
    {
        const std::filesystem::path controls = "lib/examples/js/controls";
        std::filesystem::create_directories(folder_.path() / controls);
        folder_.write("lib/three.min.js", "/* three </script> */");
        folder_.write(controls / "OrbitControls.js", "/* controls */");
    }
    Outcome run_without_three(std::vector<std::string> arguments)
    {
        write_stand_in();
        Surroundings around;
        around.environment.emplace_back("ONCOLLIDE_THREE", (folder_.path() / "lib").string());
        return run(std::move(arguments), around);
    }

    /// The contents of the element of that id.
    std::string block(const std::string& id, const std::string& file = "x.html")
    {
        const std::string page = folder_.read(file), mark = "id=\"" + id + "\">";
        const std::size_t from = page.find(mark);
        if (from == std::string::npos) return ADD_FAILURE() << "no " << id, "";
        return page.substr(from + mark.size(), page.find("</script>", from) - from - mark.size());
    }
    nlohmann::json header(const std::string& file = "x.html") { return nlohmann::json::parse(block("header", file)); }
    std::vector<float> floats(const std::string& id, std::size_t first, std::size_t count)
    {
        const std::string bytes = decoded_base64(block(id));
        std::vector<float> numbers(count);
        EXPECT_GE(bytes.size(), 4 * (first + count)) << id;
        if (bytes.size() >= 4 * (first + count)) std::memcpy(numbers.data(), bytes.data() + 4 * first, 4 * count);
        return numbers;
    }
};

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
    const Outcome outcome = run_without_three({"run", "boxes", "--bodies", "1900", "--frames", "40", "--skip", "ocst",
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

bool is_colliding(const std::uint8_t* p)
{
    return p[0] > 150 && p[0] > 2 * p[1] && p[0] > 2 * p[2];
}
bool is_within(const std::uint8_t* p)
{
    return p[0] > 150 && p[1] > 120 && p[0] > 2 * p[2];
}
bool is_blue(const std::uint8_t* p)
{
    return p[2] > 120 && p[2] > p[0] + 40;
}

/// Tests with three.js and Chromium on a software renderer.
class ViewInBrowser : public View {
protected:
    void SetUp() override
    {
        if (!std::filesystem::exists(chromium)) GTEST_SKIP() << "needs Debian's package chromium";
        if (!std::filesystem::exists(three)) GTEST_SKIP() << "needs Debian's package libjs-three";
    }

    struct Seen {
        std::string document; ///< at the end
        Decoded picture;

        /// data-NAME of the document.
        std::string data(const std::string& name) const
        {
            const std::string mark = "data-" + name + "=\"";
            const std::size_t from = document.find(mark);
            if (from == std::string::npos || from > document.find("<head>")) return "";
            return document.substr(from + mark.size(), document.find('"', from + mark.size()) - from - mark.size());
        }
    };
    Seen look(const std::string& page, const std::string& fragment, const std::string& size = "900,640",
              int milliseconds = 1500)
    {
        const Outcome outcome = browse(
            folder_, {"--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
                      "--disable-dev-shm-usage", "--enable-logging=stderr", "--run-all-compositor-stages-before-draw",
                      fmt::format("--virtual-time-budget={}", milliseconds), "--window-size=" + size,
                      "--screenshot=" + (folder_ / "x.png").string(), "--dump-dom",
                      "file://" + (folder_ / page).string() + "#" + fragment});
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        EXPECT_EQ(outcome.err.find("Uncaught"), std::string::npos) << outcome.err;
        EXPECT_EQ(outcome.err.find("THREE."), std::string::npos) << outcome.err; // no shader fails to compile
        Seen seen{outcome.out, decode(folder_.read("x.png"))};
        EXPECT_EQ(seen.data("ready"), "yes") << fragment << "\n" << outcome.err;
        EXPECT_EQ(seen.data("error"), "");
        return seen;
    }
    /// Pixels of the scene that are `wanted`: outside the panel, the legend and the strip of frames.
    template <class Wanted>
    static int in_scene(const Decoded& picture, Wanted wanted)
    {
        int count = 0;
        for (int y = 60; y < 420; ++y)
            for (int x = 0; x < 520; ++x) count += wanted(picture.at(x, y));
        return count;
    }
    /// Pixels that differ from the background.
    static int drawn(const Decoded& picture)
    {
        const std::uint8_t* paper = picture.at(260, 4);
        return in_scene(picture, [&](const std::uint8_t* p) {
            return std::abs(p[0] - paper[0]) + std::abs(p[1] - paper[1]) + std::abs(p[2] - paper[2]) > 60;
        });
    }
};

TEST_F(ViewInBrowser, EveryViewShowsWhatItIsFor)
{
    write_scene("scene.json", 1.5);
    ASSERT_EQ(run({"run", "scene.json", "--exact", "predicates", "--separate", "--quiet", "--view", "x.html"}).code, 0);
    const Seen apart = look("x.html", "frame=0&theme=light"), hit = look("x.html", "frame=7&theme=light");
    EXPECT_EQ(apart.data("frame"), "0");
    EXPECT_EQ(hit.data("frame"), "7");
    EXPECT_GT(drawn(apart.picture), 8000) << "two balls";
    EXPECT_EQ(in_scene(apart.picture, is_colliding), 0);
    EXPECT_GT(in_scene(hit.picture, is_colliding), 8000);
    const Seen dark = look("x.html", "frame=7&theme=dark");
    EXPECT_LT(dark.picture.at(260, 4)[0], 80);
    EXPECT_GT(in_scene(dark.picture, is_colliding), 8000);
    for (const char* kind : {"spheres", "boxes"}) {
        const Seen trees = look("x.html", fmt::format("frame=7&pair=0,1&trees={}&level=3&theme=light", kind));
        EXPECT_GT(in_scene(trees.picture, is_blue), 1000) << kind << " of the first body";
        EXPECT_GT(in_scene(trees.picture, is_colliding), 300) << kind << " that touch";
        EXPECT_NE(trees.document.find("touch, off by"), std::string::npos);
    }
    const Seen phone = look("x.html", "frame=7&theme=light&tab=stages", "390,844");
    EXPECT_GT(phone.picture.count(is_colliding), 2000);
    EXPECT_NE(phone.document.find("Boxes of the bodies"), std::string::npos);
}

/// A link of a clash report selects the pair and moves the camera to the clash.
TEST_F(ViewInBrowser, AClashIsSeenFromNear)
{
    const auto write_box = [&](const std::string& name, double low, double high) {
        std::string text = "OFF\n8 12 0\n";
        for (const double x : {low, high})
            for (const char* yz : {"0 0", "100 0", "100 100", "0 100"}) text += fmt::format("{} {}\n", x, yz);
        folder_.write(name, text + "3 0 2 1\n3 0 3 2\n3 4 5 6\n3 4 6 7\n3 0 1 5\n3 0 5 4\n3 1 2 6\n3 1 6 5\n3 2 3 7\n"
                                   "3 2 7 6\n3 3 0 4\n3 3 4 7\n");
    };
    write_box("left.off", 0, 100), write_box("right.off", 99, 200), write_box("far.off", 50'000, 50'100);
    EXPECT_EQ(run({"clash", "left.off", "right.off", "far.off", "--quiet", "--view", "v.html", "-o", "r.html"}).code,
              1);
    const std::string page = folder_.read("r.html"), mark = "href=\"./v.html#";
    const std::size_t begin = page.find(mark) + mark.size();
    std::string link = page.substr(begin, page.find('"', begin) - begin);
    for (std::size_t at = 0; (at = link.find("&amp;", at)) != link.npos;) link.replace(at, 5, "&");
    EXPECT_TRUE(link.starts_with("pair=0,1&isolate&at=99.5,50,50,")) << link;
    const Seen near = look("v.html", link + "&theme=light"), all = look("v.html", "frame=0&theme=light");
    const auto scale = [](const Seen& seen) {
        const std::size_t at = seen.document.find("<b>", seen.document.find("id=\"scale\""));
        return seen.document.substr(at + 3, seen.document.find("</b>", at) - at - 3);
    };
    EXPECT_EQ(scale(near), "50 mm");
    EXPECT_EQ(scale(all), "10 m");
    EXPECT_GT(in_scene(near.picture, is_colliding), 8000);
    EXPECT_LT(in_scene(all.picture, is_colliding), 1000);
    EXPECT_NE(near.document.find("surfaces cross"), std::string::npos) << "the pair is selected";
}

TEST_F(ViewInBrowser, TheSliderAndKeysChangeTheFrame)
{
    write_scene("scene.json", 1.5, "</script><script>document.title='owned'</script>");
    ASSERT_EQ(run({"run", "scene.json", "--exact", "off", "--quiet", "--view", "x.html"}).code, 0);
    folder_.write("y.html", folder_.read("x.html") + R"(<script>
const root = document.documentElement, slider = document.getElementById("scrub"), key = (k) => dispatchEvent(new KeyboardEvent("keydown", {key: k}));
slider.value = 6, slider.dispatchEvent(new Event("input"));
root.dataset.scrubbed = root.dataset.frame;
key("ArrowLeft"), root.dataset.left = root.dataset.frame;
key("Home"), root.dataset.home = root.dataset.frame;
key("End"), root.dataset.end = root.dataset.frame;
const canvas = document.getElementById("scene"), box = canvas.getBoundingClientRect();
for (const what of ["pointerdown", "pointerup"])
  canvas.dispatchEvent(new PointerEvent(what, {clientX: box.left + box.width / 4, clientY: box.top + box.height / 2}));
</script>)");
    const Seen seen = look("y.html", "frame=0&theme=light");
    EXPECT_EQ(seen.data("scrubbed"), "6");
    EXPECT_EQ(seen.data("left"), "5");
    EXPECT_EQ(seen.data("home"), "0");
    EXPECT_EQ(seen.data("end"), "7");
    EXPECT_NE(seen.document.find("class=\"body-link\""), std::string::npos) << "the clicked body is selected";
    EXPECT_EQ(seen.document.find("<title>owned"), std::string::npos);
    EXPECT_GT(in_scene(seen.picture, is_within), 8000) << "without an exact level they may touch";
}

TEST_F(ViewInBrowser, DetailIsLessWhileItPlaysAndReturnsAtRest)
{
    ASSERT_EQ(run({"run", "city", "--bodies", "400", "--frames", "30", "--quiet", "--view", "x.html"}).code, 0);
    folder_.write("y.html", folder_.read("x.html") + R"(<script>
const root = document.documentElement, play = () => dispatchEvent(new KeyboardEvent("keydown", {key: " "}));
play();
const wait = () => {
  if (+root.dataset.drawn < 3) return requestAnimationFrame(wait);
  for (const name of ["bodies", "triangles", "pixels"]) root.setAttribute("data-played-" + name, root.dataset[name]);
  play();
};
wait();
</script>)");
    const Seen seen = look("y.html", "frame=0&theme=light", "900,640", 60000);
    const auto rest = [&](const char* name) { return std::stoi(seen.data(name)); };
    const auto played = [&](const char* name) { return std::stoi(seen.data(std::string("played-") + name)); };
    EXPECT_GT(rest("frame"), 0);
    EXPECT_GT(rest("bodies"), 300);
    EXPECT_EQ(played("bodies"), rest("bodies")) << "nothing disappears";
    EXPECT_LT(played("triangles"), rest("triangles") / 2);
    EXPECT_LT(played("pixels"), rest("pixels") / 2 + 1);
    const Seen never = look("x.html", fmt::format("frame={}&theme=light", rest("frame")));
    EXPECT_EQ(seen.data("triangles"), never.data("triangles"));
    EXPECT_EQ(seen.data("pixels"), never.data("pixels"));
}

TEST_F(ViewInBrowser, SmallBodiesHaveTheirColoursAndHideWhatIsBehind)
{
    // A wall of 24 x 16 colliding pairs of spheres, and behind the first sphere of each pair, as seen in the page, one
    // that does not collide.
    std::string placed;
    const auto put = [&](double x, double y, double z) {
        placed += fmt::format(R"(,{{"geometry": "ball", "position": [{}, {}, {}]}})", x, y, z);
    };
    for (int row = 0; row < 16; ++row)
        for (int column = 0; column < 24; ++column) {
            const double x = 2.5 * column, z = 1.5 * row;
            put(x, 0, z), put(x + 0.9, 0, z), put(x + 1.1, 2, z - 1.24);
        }
    folder_.write("wall.json", R"({"geometries": {"ball": {"mesh": {"generate": {"kind": "sphere", "radius": 0.5,
        "triangles": 512}}}}, "bodies": [)" +
                                   placed.substr(1) + "]}");
    ASSERT_EQ(run({"run", "wall.json", "--exact", "on", "--quiet", "--view", "x.html"}).code, 0);
    folder_.write("y.html", folder_.read("x.html") + R"(<script>
for (const key of ["l", "c"]) dispatchEvent(new KeyboardEvent("keydown", {key})); // hides the marks
</script>)");
    const Seen seen = look("y.html", "theme=light");
    EXPECT_EQ(seen.data("bodies"), "1152");
    EXPECT_EQ(seen.data("triangles"), "2304") << "they are drawn as sprites";
    EXPECT_GT(in_scene(seen.picture, is_colliding), 30'000) << "24,000 if the spheres behind were drawn first";
}

TEST_F(ViewInBrowser, RegionsAndMarksOfALargeScene)
{
    ASSERT_EQ(
        run({"run", "city", "--bodies", "400", "--frames", "4", "--exact", "predicates", "--quiet", "--view", "x.html"})
            .code,
        0);
    const Seen plain = look("x.html", "frame=3&theme=light"), regions = look("x.html", "frame=3&theme=light&regions");
    EXPECT_GT(drawn(plain.picture), 5000);
    EXPECT_EQ(plain.data("frame"), "3");
    EXPECT_GT(std::stoi(plain.data("bodies")), 100);
    EXPECT_EQ(regions.data("error"), "");
}

} // namespace
} // namespace oncollide::test
