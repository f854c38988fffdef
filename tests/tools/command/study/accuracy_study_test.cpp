#include "tools/browser.hpp"
#include "tools/command/study/study_fixture.hpp"
#include "tools/decoded_png.hpp"

#include <regex>
#include <set>

namespace oncollide::test {
namespace {

/// Why `page` is not well-formed XML, regarding tags, attributes and entities; empty if it is.
std::string why_malformed(const std::string& page)
{
    std::vector<std::string> open;
    static const std::regex tag(R"(/?[A-Za-z][\w-]*(\s+[\w:-]+="[^"<]*")*\s*/?)");
    static const std::regex entity(R"(&(lt|gt|amp|quot);)");
    for (std::size_t at = page.find('<'); at != std::string::npos;) {
        const std::size_t end = page.find('>', at);
        if (end == std::string::npos) return "a tag without an end";
        const std::string inside = page.substr(at + 1, end - at - 1),
                          name = inside.substr(0, inside.find_first_of(" /"));
        if (inside.size() > 2000) { // too long for the expression
            if (!inside.starts_with("img ") || !inside.ends_with("\"/")) return "no picture: " + inside.substr(0, 80);
        } else if (!inside.starts_with("!DOCTYPE")) {
            if (!std::regex_match(inside, tag)) return "not a tag: " + inside;
            if (inside[0] == '/') {
                if (open.empty() || open.back() != inside.substr(1))
                    return "closes an element that is not open: " + inside;
                open.pop_back();
            } else if (inside.back() != '/') {
                open.push_back(name);
            }
        }
        const std::size_t next = page.find('<', end);
        const std::string text = page.substr(end + 1, next == std::string::npos ? next : next - end - 1);
        if (std::regex_replace(text, entity, "").find('&') != std::string::npos) return "an unknown entity: " + text;
        at = next;
    }
    return open.empty() ? "" : "left open: " + open.back();
}

/// The page must contain no scripts and no references that a browser would fetch.
void expect_self_contained(const std::string& page)
{
    EXPECT_EQ(why_malformed(page), "");
    for (const char* load : {"src=\"http", "href=", "url(", "@import", "<script", "<link", "<iframe", "src=\"/"})
        EXPECT_EQ(page.find(load), std::string::npos) << load;
    EXPECT_NE(page.find("@media print"), std::string::npos);
}

TEST_F(Study, KnowsHowFarApartFalsePositivesAre)
{
    const nlohmann::json all =
        study({"cubes.json", "--depths", "2,8", "--warm-up", "0", "--csv", "s.csv", "--peers", "fcl"});
    EXPECT_EQ(all["header"]["colliding"], 3);
    EXPECT_EQ(all["variants"].size(), 6u);
    for (const char* spheres : {"spheres", "OBBs"}) {
        const nlohmann::json exact = variant(all, fmt::format("{}, predicates", spheres));
        EXPECT_EQ(exact["colliding"], 3);
        EXPECT_EQ(exact["error"], 0);
        EXPECT_EQ(exact["false_positives"], 0);
    }
    const nlohmann::json coarse = variant(all, "spheres, depth 2"), fine = variant(all, "spheres, depth 8");
    EXPECT_EQ(coarse["within"], 9);
    EXPECT_EQ(coarse["false_positives"], 6);
    EXPECT_NEAR(coarse["false_positive_distance_worst"], 0.05, 1e-9);
    EXPECT_NEAR(coarse["false_positive_distance_median"], 0.04, 1e-9);
    EXPECT_NEAR(coarse["error"], std::sqrt(3) / 2, 1e-4) << "four radii of a quarter of the cube's";
    EXPECT_EQ(coarse["false_positives_by_tenth_of_bound"], nlohmann::json({6, 0, 0, 0, 0, 0, 0, 0, 0, 0}));
    EXPECT_EQ(fine["false_positives"], 0);
    EXPECT_EQ(fine["separate"], 6);
    for (const nlohmann::json& row : all["variants"]) {
        SCOPED_TRACE(row["variant"]);
        for (const char* fault : {"missed", "invented", "bounds_broken"}) EXPECT_EQ(row[fault], 0) << fault;
        EXPECT_GT(row["ms_mean"], 0);
        EXPECT_GT(row["times_fcl"], 0);
        EXPECT_GT(row["nodes_needed"], 0);
        EXPECT_LE(row["nodes_needed"], row["nodes_all"]);
        EXPECT_EQ(row["stages"].size(), 5u);
        EXPECT_GT(row["peak_bytes"], 0);
    }
    EXPECT_GT(fine["node_pairs"], coarse["node_pairs"]);
    EXPECT_LT(fine["nodes_needed"], 0.9 * fine["nodes_all"].get<double>()) << "the far sides of the cubes";
    EXPECT_EQ(peer(all, "FCL")["colliding"], 3);
    EXPECT_EQ(peer(all, "FCL")["missed"], 0);
    EXPECT_EQ(count_of(folder_.read("s.csv"), "\n"), 8u);
}

TEST_F(Study, WhatWasNeededCountsCellsThatWereDroppedSince)
{
    const std::vector<std::string> settings{"cubes.json", "--depths", "6",  "--bounding-volume",
                                            "sphere",     "--exact",  "off"};
    std::vector<std::string> forgetful = settings;
    forgetful.insert(forgetful.end(), {"--age", "1"});
    EXPECT_EQ(study(settings)["variants"][0]["nodes_needed"], study(forgetful)["variants"][0]["nodes_needed"]);
}

TEST_F(Study, TheDialCanBeAnErrorInMetres)
{
    const nlohmann::json all = study({"cubes.json", "--max-errors", "0.5,0.01", "--exact", "off"});
    for (const char* spheres : {"spheres", "OBBs"})
        for (const char* error : {"0.5", "0.01"}) {
            const nlohmann::json row = variant(all, fmt::format("{}, {} m", spheres, error));
            EXPECT_GT(row["error"], 0);
            EXPECT_LE(row["error"], std::stod(error));
        }
}

TEST_F(Study, WhatIsWithinTheClearanceCounts)
{
    const nlohmann::json all = study({"cubes.json", "--depths", "8", "--clearance", "0.045"});
    EXPECT_EQ(all["header"]["colliding"], 3 + 4);
    EXPECT_EQ(variant(all, "spheres, depth 8")["missed"], 0);
}

TEST_F(Study, WhatOnlyTouchesCanBeLeftOut)
{
    folder_.write("touch.json", R"({"frames": 2, "geometries": {"cube": {"mesh": {"generate": {"kind": "box", "half":
        [0.5, 0.5, 0.5]}}}}, "bodies": [{"name": "a", "geometry": "cube"}, {"name": "b", "geometry": "cube",
        "position": [1, 0.25, 0.25], "motion": {"drift": {"velocity": [-0.0078125, 0, 0]}}}]})");
    const std::vector<std::string> settings{"touch.json", "--depths", "3", "--warm-up", "0"};
    EXPECT_EQ(study(settings)["header"]["colliding"], 2);
    std::vector<std::string> ignoring = settings;
    ignoring.push_back("--ignore-touching");
    const nlohmann::json all = study(ignoring);
    EXPECT_EQ(all["header"]["colliding"], 1) << "in the second frame they cross";
    EXPECT_EQ(variant(all, "OBBs, predicates")["separate"], 1);
    const nlohmann::json spheres = variant(all, "spheres, depth 3");
    EXPECT_EQ(spheres["false_positives"], 1);
    EXPECT_NEAR(spheres["false_positive_distance_worst"], 0, 1e-15);
    expect_error(64, {"accuracy", "study", "touch.json", "--ignore-touching", "--exact", "off"},
                 {"--ignore-touching", "predicates"});
}

TEST_F(Study, JudgesBodiesOfEveryKind)
{
    folder_.write("kinds.json", R"({"frames": 2, "geometries": {
        "plane": {"shape": {"kind": "half_space"}}, "land": {"terrain": {"hills": {"cells": [12, 12], "spacing": 0.5,
        "height": 1, "seed": 3}}}, "rooms": {"octomap": {"building": {"rooms": 1, "resolution": 0.25}}},
        "egg": {"shape": {"kind": "ellipsoid", "semi_axes": [0.3, 0.5, 0.7]}},
        "cone": {"shape": {"kind": "cone", "radius": 0.4, "length": 1}},
        "box": {"mesh": {"generate": {"kind": "box", "half": [0.5, 0.5, 0.5]}}}}, "bodies": [
        {"geometry": "plane", "position": [0, 0, -0.2]}, {"geometry": "land"}, {"geometry": "rooms"},
        {"geometry": "egg", "position": [1, 1, 0.9]}, {"geometry": "cone", "position": [1.5, 0.5, 0.7]},
        {"geometry": "box", "position": [0.5, 1.5, 0.3], "motion": {"drift": {"velocity": [0.1, 0, 0.1]}}}]})");
    for (const char* dial : {"--max-errors", "--depths"}) {
        const nlohmann::json all = study({"kinds.json", dial, "1", "--warm-up", "0", "--peers", "fcl"});
        EXPECT_GT(all["header"]["colliding"], 10);
        EXPECT_EQ(all["variants"].size(), 4u);
        for (const nlohmann::json& row : all["variants"]) {
            SCOPED_TRACE(row["variant"]);
            for (const char* fault : {"missed", "invented", "bounds_broken"}) EXPECT_EQ(row[fault], 0) << fault;
        }
        EXPECT_EQ(peer(all, "FCL")["missed"], 0);
    }
}

/// FCL's OBB tree of a half-space used to end the program.
TEST_F(Study, PlanesStandBesideFcl)
{
    std::string bodies = R"({"geometry": "plane", "static": true}, {"geometry": "plane", "position": [0, 0, -1]})";
    for (int i = 0; i < 40; ++i)
        bodies += fmt::format(R"(, {{"geometry": "ball", "position": [{}, {}, {}]}})", i % 7, i / 7, 0.03 * i);
    folder_.write("plane.json", fmt::format(R"({{"frames": 2, "geometries": {{"plane": {{"shape": {{"kind":
        "half_space"}}}}, "ball": {{"shape": {{"kind": "sphere", "radius": 0.5}}}}}}, "bodies": [{}]}})",
                                            bodies));
    for (const std::vector<std::string>& command : {std::vector<std::string>{"accuracy", "plane.json"},
                                                    {"accuracy", "study", "plane.json", "--depths", "2"},
                                                    {"run", "plane.json", "--exact", "fcl"}}) {
        const Outcome outcome = run(command);
        EXPECT_EQ(outcome.code, 0) << command[0] << outcome.out << outcome.err;
    }
}

TEST_F(Study, ReadsPosesAndHoldsTheirAnswersAgainstTheTruth)
{
    write_cube("cube.off");
    const std::string rotated = "1 0 0 0 1 0 0 0 1 ";
    folder_.write("p.txt", "0 0 " + rotated + "0.75 0.1 0.2\n1 0.5 " + rotated + "2 0 0\n" +
                               // A face 0.1 m from an edge.
                               "0 0 0.70710678118654752 -0.70710678118654752 0 0.70710678118654752 0.70710678118654752 "
                               "0 0 0 1 0.92426406871192852 0.92426406871192852 0\n");
    folder_.write("p_expected.txt", "0 1 24\n1 0 0\n2 0 0\n");
    const std::vector<std::string> arguments{"cube.off", "cube.off", "--poses", "p.txt", "--depths", "2"};
    const nlohmann::json right = study(arguments);
    EXPECT_EQ(right["header"]["frames"], 3);
    EXPECT_EQ(right["header"]["colliding"], 1);
    EXPECT_NEAR(variant(right, "spheres, depth 2")["false_positive_distance_worst"], 0.1, 1e-9);
    folder_.write("p_expected.txt", "0 0 0\n1 0 0\n2 0 0\n");
    study(arguments, 70);
    const nlohmann::json generated = study({"cube.off", "cube.off", "--count", "4", "--distances", "0,10"});
    EXPECT_EQ(generated["header"]["frames"], 8);
}

TEST_F(Study, ThePageNeedsNothingElse)
{
    const Outcome outcome =
        run({"accuracy", "study", "cubes.json", "--depths", "2-4", "--html", "s.html", "--peers", "fcl"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "") << "no progress display off a terminal";
    EXPECT_EQ(folder_.list(), (std::vector<std::string>{"cubes.json", "s.html"}));
    const std::string page = folder_.read("s.html");
    expect_self_contained(page);
    EXPECT_EQ(count_of(page, "<svg "), 4u);
    EXPECT_EQ(count_of(page, "<tr>"), 2 * (1u + 8 + 1)) << "two tables: header, variants, FCL";
    EXPECT_NE(page.find("<pre>oncollide accuracy study cubes.json --depths 2-4 --html s.html --peers fcl</pre>"),
              std::string::npos);
    for (const char* word : {"b &lt;&amp;&gt;", "false positive: 0.05 m apart", ">exact</text>", "★", "FCL missed 0"})
        EXPECT_NE(page.find(word), std::string::npos) << word;
    // Without colour, lines are distinguished by their markers and labels.
    const std::regex mark("<path fill=\"[^\"]*\" transform=\"[^\"]*\" d=\"([^\"]*)\"/>");
    std::set<std::string> markers;
    for (std::sregex_iterator it(page.begin(), page.end(), mark), end; it != end; ++it) markers.insert((*it)[1]);
    const bool front = page.find(">fastest at its error") != std::string::npos; // not if an exact engine is the fastest
    EXPECT_EQ(markers.size(), front ? 6u : 5u) << "two dials, two exact levels, FCL, the front";
    EXPECT_EQ(count_of(page, "src=\"data:image/png;base64,iVBORw0KGgo"), count_of(page, "<figcaption>"));
    EXPECT_GT(count_of(page, "<figcaption>"), 0u);
}

/// The labels are right of the data, and the picture is as wide as they are.
TEST_F(Study, TheFigureIsAFileForAPaper)
{
    const Outcome outcome =
        run({"accuracy", "study", "cubes.json", "--depths", "2-4", "--svg", "s.svg", "--peers", "fcl"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("accuracy, exact level and bounding volume by variant, mode surface"), std::string::npos)
        << outcome.out;
    EXPECT_EQ(outcome.out.find("bounding volume sphere"), std::string::npos) << "OBBs ran, too";
    const std::string svg = folder_.read("s.svg");
    EXPECT_EQ(why_malformed(svg), "");
    EXPECT_TRUE(svg.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"")) << svg.substr(0, 100);
    const double width = std::stod(svg.substr(svg.find("width=\"") + 7));
    const std::regex point("<path fill=\"[^\"]*\" transform=\"translate\\(([0-9.]+) "),
        label("<text x=\"([0-9.]+)\"[^>]*class=\"(main|value)\">([^<]*)<");
    double left = 1e9;
    int labels = 0;
    for (std::sregex_iterator it(svg.begin(), svg.end(), label), end; it != end; ++it, ++labels) {
        left = std::min(left, std::stod((*it)[1]));
        EXPECT_LT(std::stod((*it)[1]) + 8 * double((*it)[3].length()), width) << (*it)[3];
    }
    EXPECT_GE(labels, 5);
    int points = 0;
    for (std::sregex_iterator it(svg.begin(), svg.end(), point), end; it != end; ++it, ++points)
        EXPECT_LT(std::stod((*it)[1]), left);
    EXPECT_GT(points, 2 * labels - 1) << "each label has its marker, too";
    expect_error(64, {"accuracy", "study", "cubes.json", "--svg", "s.pdf"}, {"--svg s.pdf", ".svg", "rsvg-convert"});
}

TEST_F(Study, UnlessToldItMeasuresErrorsInMetres)
{
    const nlohmann::json all = study({"cubes.json", "--warm-up", "0", "--peers", "none", "--exact", "off"});
    // The diagonal of a cube of side 1 is 1.7 m; half of it is 0.87 m.
    for (const char* error : {"0.87", "0.35", "0.17", "0.087", "0.035", "0.017"})
        for (const char* volume : {"spheres", "OBBs"}) {
            const nlohmann::json row = variant(all, fmt::format("{}, {} m", volume, error));
            EXPECT_LE(row["error"].get<double>(), std::stod(error)) << row;
        }
    EXPECT_EQ(all["variants"].size(), 12u);
    EXPECT_NE(all.dump().find("least of 3 runs"), std::string::npos) << all["header"];
}

TEST_F(Study, WithoutARendererThePageGoesWithoutPictures)
{
    const Outcome outcome =
        run({"accuracy", "study", "cubes.json", "--depths", "2", "--html", "s.html", "--gpu", "63"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const std::string page = folder_.read("s.html");
    expect_self_contained(page);
    EXPECT_NE(page.find("No pictures: "), std::string::npos);
    EXPECT_NE(page.find("no GPU 63"), std::string::npos);
    EXPECT_EQ(page.find("<img"), std::string::npos);
}

TEST_F(Study, ShowsWhatOcclusionQueriesMiss)
{
    folder_.write("needles.json", R"({"frames": 12, "geometries": {"needles": {"mesh": {"generate": {"kind": "needles",
        "count": 200, "length": 0.5, "aspect": 100000, "size": 1, "seed": 7}}}, "ball": {"mesh": {"generate":
        {"kind": "sphere", "radius": 0.4, "triangles": 500}}}}, "bodies": [{"name": "needles", "geometry": "needles"},
        {"name": "ball", "geometry": "ball", "position": [-1, 0, 0],
         "motion": {"drift": {"velocity": [0.1, 0, 0]}}}]})");
    const nlohmann::json all =
        study({"needles.json", "--backend", "cpu,gl-query", "--viewport", "8,16", "--bounding-volume", "sphere",
               "--exact", "off", "--depths", "6", "--html", "s.html"});
    EXPECT_EQ(all["variants"].size(), 3u);
    EXPECT_EQ(variant(all, "spheres, depth 6")["missed"], 0);
    const nlohmann::json query = variant(all, "gl-query 8 px, spheres, depth 6");
    EXPECT_GT(query["missed"], 0);
    EXPECT_EQ(query["certified"], false);
    EXPECT_EQ(query["on_front"], false);
    EXPECT_GT(query["queries"], 0);
    const std::string page = folder_.read("s.html");
    expect_self_contained(page);
    EXPECT_NE(page.find("needles and ball; missed: they collide"), std::string::npos);
}

TEST_F(Study, ABrowserDrawsThePage)
{
    if (!std::filesystem::exists(chromium)) GTEST_SKIP() << "no chromium";
    ASSERT_EQ(run({"accuracy", "study", "cubes.json", "--depths", "2-4", "--html", "s.html", "--peers", "all"}).code,
              0);
    const std::string page = "file://" + (folder_ / "s.html").string();
    const auto draw = [&](const std::string& what) {
        const Outcome outcome = browse(folder_, {"--disable-gpu", "--window-size=1000,2200", what, page});
        EXPECT_EQ(outcome.code, 0) << outcome.err;
    };
    draw("--screenshot=" + (folder_ / "s.png").string());
    const Decoded image = decode(folder_.read("s.png"));
    EXPECT_EQ(image.width, 1000);
    EXPECT_EQ(image.height, 2200);
    const auto is_bar = [](const std::uint8_t* p) { return p[0] == 0 && p[1] == 0x72 && p[2] == 0xb2; };
    int bars = 0;
    for (int y = 850; y < image.height; ++y) // below the curve, whose first line has that colour too
        for (int x = 0; x < image.width; ++x) bars += is_bar(image.at(x, y));
    EXPECT_GT(bars, 300);
    EXPECT_GT(image.count([](const std::uint8_t* p) { return p[0] < 100 && p[1] < 100 && p[2] < 100; }), 5000)
        << "text";
    EXPECT_FALSE(image.count([](const std::uint8_t* p) { return p[0] < 250; }, 985) > 0)
        << "nothing is clipped at the right";
    draw("--print-to-pdf=" + (folder_ / "s.pdf").string());
    EXPECT_TRUE(folder_.read("s.pdf").starts_with("%PDF"));
}

TEST_F(Study, RefusesWhatMakesNoSense)
{
    write_cube("cube.off");
    const auto refuse = [&](std::vector<std::string> more, const std::vector<std::string>& words, int code = 64) {
        more.insert(more.begin(), {"accuracy", "study"});
        expect_error(code, more, words);
    };
    refuse({}, {"scene or two meshes"});
    refuse({"cubes.json", "--depths", "0"}, {"--depths 0"});
    refuse({"cubes.json", "--depths", "3", "--max-errors", "0.1"}, {"--depths and --max-errors"});
    refuse({"cubes.json", "--max-errors", "0.1,x"}, {"--max-errors x", "a length"});
    refuse({"cubes.json", "--max-errors", "-1"}, {"max-error"});
    refuse({"cubes.json", "--bounding-volume", "auto"}, {"--bounding-volume auto", "sphere, obb"});
    refuse({"cubes.json", "--bounding-volume", "round"}, {"round"});
    refuse({"cubes.json", "--bounding-volume", "obb", "--backend", "gl-query"}, {"--bounding-volume obb", "cpu"});
    refuse({"cubes.json", "--exact", "off,maybe"}, {"maybe"});
    refuse({"cubes.json", "--backend", "gpu"}, {"gpu", "gl-compute"});
    refuse({"cubes.json", "--viewport", "8,", "--backend", "gl-query"}, {"--viewport 8,"});
    refuse({"cubes.json", "--peers", "fcl,jolt"}, {"--peers jolt", "valid: fcl, all, none"});
    refuse({"cubes.json", "--every", "0"}, {"--every 0"});
    refuse({"cubes.json", "--repeats", "0"}, {"--repeats 0"});
    refuse({"cubes.json", "--warm-up", "-1"}, {"--warm-up -1"});
    refuse({"cubes.json", "--count", "3"}, {"cubes.json", "two meshes"});
    refuse({"cubes.json", "--poses"}, {"cubes.json", "two meshes"});
    refuse({"cubes.json", "--csv", "x", "--html", "x"}, {"both go to 'x'"});
    refuse({"cubes.json", "--html", "cubes.json"}, {"overwrite the input"});
    refuse({"cube.off", "cube.off", "cube.off"}, {"a scene or two meshes"});
    refuse({"cube.off", "cube.off", "--poses"}, {"--poses", "own"});
    refuse({"cube.off", "cube.off", "--count", "0"}, {"--count 0"});
    refuse({"cube.off", "none.off"}, {"none.off"}, 66);
    refuse({"cube.off"}, {"oncollide accuracy study cube.off", "a scene", "two meshes", "cube.off OTHER"});
    refuse({"none.json"}, {"none.json"}, 66);
    refuse({"cubes.json", "--html", "no/where.html"}, {"no/where.html"}, 73);
    refuse({"cubes.json", "--backend", "gl-query", "--gpu", "63"}, {"no GPU 63"}, 71);
    EXPECT_EQ(folder_.list(), (std::vector<std::string>{"cube.off", "cubes.json"}));
}

} // namespace
} // namespace oncollide::test
