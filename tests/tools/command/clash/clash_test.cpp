// oncollide clash: its findings in assemblies with known clashes, and the contents of each report.
#include "clash/parts/name_pattern.hpp"
#include "tools/command/clash/clash_fixture.hpp"
#include "tools/csv_rows.hpp"
#include <oncollide/samples/generators.hpp>

namespace oncollide::test {
namespace {

using nlohmann::json;

TEST_F(ClashCommand, NamesTheClashesTheWorstFirst)
{
    const Outcome outcome = clash({"--clearance", "1mm", "-o", "r.json"});
    EXPECT_EQ(outcome.code, 1);
    EXPECT_EQ(outcome.err, "");
    EXPECT_NE(outcome.out.find("6 parts of 6 files, 72 triangles, 111 x 20 x 25 mm\n"
                               "3 clashes: 1 enclosed, 1 crossing, 1 near\n"
                               "1 pair touches: 1 exactly; "),
              std::string::npos)
        << outcome.out;
    const std::size_t enclosed = outcome.out.find("1  enclosed"), crossing = outcome.out.find("2  crossing"),
                      near = outcome.out.find("3  near");
    EXPECT_TRUE(enclosed < crossing && crossing < near && near != outcome.out.npos) << outcome.out;
    EXPECT_NE(outcome.out.find("0.5 mm apart"), std::string::npos) << outcome.out;
    EXPECT_EQ(pairs("r.json"), (Pairs{"b e enclosed new", "a b crossing new", "a c touching contact", "a d near new"}));
    EXPECT_NE(clash({"--clearance", "1", "--list", "1"}).out.find("and 2 more"), std::string::npos);
}

TEST_F(ClashCommand, TheJsonReportMeasures)
{
    clash({"--clearance", "1mm", "-o", "r.json"});
    const json report = read_json("r.json");
    EXPECT_EQ(report["schema"], "oncollide.clash");
    EXPECT_EQ(report["unit"], "mm");
    EXPECT_EQ(report["parts"], 6);
    EXPECT_EQ(report["counts"]["new"],
              (json{{"duplicate", 0}, {"enclosed", 1}, {"crossing", 1}, {"within", 0}, {"touching", 0}, {"near", 1}}));
    const json &enclosed = report["clashes"][0], &crossing = report["clashes"][1], &near = report["clashes"][3];
    EXPECT_EQ(enclosed["contact"], nullptr);
    EXPECT_EQ(enclosed["overlap"], (json{{"min", {15, 1, 1}}, {"max", {20, 5, 5}}}));
    EXPECT_NEAR(enclosed["ball"]["diameter"]["lower"].get<double>(), 4, 0.04);
    EXPECT_GE(enclosed["ball"]["diameter"]["upper"].get<double>(), 4);
    EXPECT_NEAR(enclosed["volume"]["lower"].get<double>(), 80, 4);
    EXPECT_GE(enclosed["volume"]["upper"].get<double>(), 80);
    EXPECT_NEAR(crossing["ball"]["diameter"]["lower"].get<double>(), 1, 0.01);
    EXPECT_NEAR(crossing["volume"]["upper"].get<double>(), 100, 5);
    EXPECT_NEAR(enclosed["thickness"].get<double>(), 4, 1e-12);
    EXPECT_NEAR(crossing["thickness"].get<double>(), 1, 1e-12);
    EXPECT_NEAR(crossing["depth"].get<double>(), 1, 1e-9);
    EXPECT_EQ(crossing["deepest"]["of"], "a");
    EXPECT_EQ(crossing["contact"], (json{{"min", {9, 0, 0}}, {"max", {9, 10, 10}}}));
    EXPECT_EQ(crossing["overlap"], (json{{"min", {9, 0, 0}}, {"max", {10, 10, 10}}}));
    EXPECT_EQ(crossing["a"]["file"], "a.off");
    EXPECT_LE(near["distance"]["lower"].get<double>(), 0.5);
    EXPECT_NEAR(near["distance"]["upper"].get<double>(), 0.5, 1e-9);
    const Outcome piped = clash({"--clearance", "1mm", "-o", "-"});
    EXPECT_EQ(json::parse(piped.out), report) << "standard output has only the report";
}

TEST_F(ClashCommand, EveryReportIsReadBack)
{
    clash({"--clearance", "1mm", "-o", "r.csv", "-o", "r.xml", "-o", "r.html"});
    auto csv = read_csv(folder_.read("r.csv"));
    ASSERT_EQ(csv.size(), 4u);
    EXPECT_EQ(csv[1]["kind"], "crossing");
    EXPECT_EQ(csv[1]["a"], "a");
    EXPECT_EQ(std::stod(csv[1]["thickness"]), 1);
    EXPECT_EQ(std::stod(csv[1]["contact_min_x"]), 9);
    EXPECT_NEAR(std::stod(csv[3]["distance"]), 0.5, 1e-9);
    const std::string xml = folder_.read("r.xml");
    EXPECT_NE(xml.find("tests=\"4\" failures=\"3\" errors=\"0\" skipped=\"0\""), std::string::npos) << xml;
    EXPECT_NE(xml.find("<testcase classname=\"clash.crossing\" name=\"a and b\"><failure type=\"crossing\" "
                       "message=\"crossing: ball of 1 mm, at 9.5 5 5\"/></testcase>"),
              std::string::npos)
        << xml;
    const std::string page = folder_.read("r.html");
    EXPECT_NE(page.find("<h2>Clashes (3)</h2>"), std::string::npos);
    EXPECT_NE(page.find("<h2>Pairs that only touch, or may do so (not a clash) (1)</h2>"), std::string::npos);
    for (const char* outside : {"http://", "https://", "src=\"/", "@import", "url("})
        EXPECT_EQ(page.find(outside), std::string::npos) << "a page needs no other files: " << outside;
}

TEST_F(ClashCommand, ThePageShowsEachClash)
{
    if (run({"doctor"}).out.find("llvmpipe") == std::string::npos) GTEST_SKIP() << "no renderer that is known";
    clash({"--clearance", "1mm", "-o", "r.html"});
    const std::string page = folder_.read("r.html");
    std::size_t pictures = 0;
    for (std::size_t at = 0; (at = page.find("data:image/png;base64,", at)) != page.npos; ++at) ++pictures;
    EXPECT_EQ(pictures, 3u);
    clash({"--clearance", "1mm", "--pictures", "1", "-o", "r.html"});
    EXPECT_NE(folder_.read("r.html").find("Pictures of the 1 most severe clashes of 3"), std::string::npos);
}

TEST_F(ClashCommand, APageComesWithoutPicturesWhereNothingDraws)
{
    files_ = small_assembly();
    const Outcome outcome = run({"clash", "a.off", "b.off", "-o", "r.html"},
                                {.folder = {}, .environment = {{"__EGL_VENDOR_LIBRARY_FILENAMES", "/nowhere"}}});
    EXPECT_EQ(outcome.code, 1) << outcome.err;
    const std::string page = folder_.read("r.html");
    EXPECT_NE(page.find("No pictures: "), std::string::npos);
    EXPECT_NE(page.find("Clashes (1)"), std::string::npos);
}

TEST_F(ClashCommand, TouchingIsAClashOnRequestAndSmallOverlapsTouchWithinATolerance)
{
    EXPECT_EQ(clash({"--touching", "-o", "r.json"}).code, 1);
    EXPECT_EQ(pairs("r.json"), (Pairs{"b e enclosed new", "a b crossing new", "a c touching new"}));
    EXPECT_EQ(clash({"--tolerance", "1.001mm", "-o", "r.json"}).code, 1);
    EXPECT_EQ(pairs("r.json"),
              (Pairs{"b e enclosed new", "a b touching contact", "a c touching contact", "a d touching contact"}));
    clash({"--tolerance", "0.09cm", "-o", "r.json"});
    EXPECT_TRUE(pairs("r.json").contains("a b crossing new"));
}

TEST_F(ClashCommand, ABlockInACornerTouchesWithinATolerance)
{
    // A bracket of a floor and a wall in one file, and a block that penetrates both by 0.001.
    write_box("block.off", {-0.001, 1, -0.001}, {5, 9, 5});
    folder_.write("bracket.off", "OFF\n12 20 0\n-3 0 -3\n9 0 -3\n9 0 0\n0 0 0\n0 0 9\n-3 0 9\n"
                                 "-3 10 -3\n9 10 -3\n9 10 0\n0 10 0\n0 10 9\n-3 10 9\n"
                                 "3 0 1 2\n3 0 2 3\n3 0 3 4\n3 0 4 5\n3 6 8 7\n3 6 9 8\n3 6 10 9\n3 6 11 10\n"
                                 "3 0 6 1\n3 1 6 7\n3 1 7 2\n3 2 7 8\n3 2 8 3\n3 3 8 9\n3 3 9 4\n3 4 9 10\n"
                                 "3 4 10 5\n3 5 10 11\n3 5 11 0\n3 0 11 6\n");
    for (const char* tolerance : {"0", "0.0005", "0.01"}) {
        const Outcome outcome = run({"clash", "block.off", "bracket.off", "--tolerance", tolerance, "-o", "r.json"});
        EXPECT_EQ(outcome.code, std::string(tolerance) == "0.01" ? 0 : 1) << tolerance << "\n" << outcome.out;
        EXPECT_EQ(outcome.out.find("not closed"), std::string::npos) << outcome.out;
    }
    EXPECT_EQ(pairs("r.json"), (Pairs{"block bracket touching contact"}));
}

TEST_F(ClashCommand, UnitsAreThoseOfTheFiles)
{
    EXPECT_EQ(clash({"--units", "in", "--clearance", "12mm", "-o", "r.json"}).code, 1);
    EXPECT_FALSE(pairs("r.json").contains("a d near new")) << "half an inch is more than 12 mm";
    clash({"--units", "in", "--clearance", "13mm", "-o", "r.json"});
    EXPECT_TRUE(pairs("r.json").contains("a d near new"));
    // All in metres except f, which then is at 0.1 m, inside a.
    clash({"--units", "m", "--units", "f*=mm", "-o", "r.json"});
    EXPECT_EQ(read_json("r.json")["unit"], "m");
    EXPECT_TRUE(pairs("r.json").contains("a f crossing new"));
}

TEST_F(ClashCommand, IgnoredPairsAndTheBaselineGoRoundAndRound)
{
    EXPECT_EQ(clash({"--clearance", "1", "-o", "old.json", "-o", "old.csv"}).code, 1);
    // All known clashes are ignored: rows of a report are a list of pairs.
    Outcome outcome = clash({"--clearance", "1", "--ignore", "old.csv", "-o", "r.json"});
    EXPECT_EQ(outcome.code, 0) << outcome.out;
    EXPECT_NE(outcome.out.find("no clashes\n4 pairs ignored, listed in old.csv"), std::string::npos) << outcome.out;
    folder_.write("some.csv", "# the press fit\n\nb,a # meant\n\"e*\", b\nnobody,a\n");
    outcome = clash({"--clearance", "1", "--ignore", "some.csv", "-o", "r.json", "-o", "r.xml"});
    EXPECT_EQ(outcome.code, 1);
    EXPECT_EQ(pairs("r.json"),
              (Pairs{"b e enclosed ignored", "a b crossing ignored", "a c touching contact", "a d near new"}));
    EXPECT_NE(outcome.err.find("some.csv: line 5: no part is named 'nobody'"), std::string::npos) << outcome.err;
    EXPECT_NE(folder_.read("r.xml").find("<skipped message=\"ignored: enclosed"), std::string::npos);

    outcome = clash({"--clearance", "1", "--baseline", "old.json", "-o", "same.json"});
    EXPECT_EQ(outcome.code, 0) << outcome.out;
    EXPECT_EQ(pairs("same.json"),
              (Pairs{"b e enclosed active", "a b crossing active", "a c touching contact", "a d near active"}));
    // d comes nearer and crosses, e is removed, a new part is added.
    write_box("d.off", {-10, 0, 0}, {0.5, 10, 10});
    write_box("e.off", {95, 0, 0}, {100.5, 5, 5});
    outcome = clash({"--clearance", "1", "--baseline", "same.json", "-o", "r.json", "-o", "r.html"});
    EXPECT_EQ(outcome.code, 1);
    EXPECT_EQ(pairs("r.json"),
              (Pairs{"a b crossing active", "a c touching contact", "a d crossing new", "e f crossing new"}))
        << outcome.out;
    EXPECT_NE(outcome.out.find("1 clash active, also in same.json; 1 resolved"), std::string::npos) << outcome.out;
    EXPECT_NE(outcome.out.find("crossing (was near)"), std::string::npos) << outcome.out;
    const json resolved = read_json("r.json")["resolved"];
    ASSERT_EQ(resolved.size(), 1u);
    EXPECT_EQ((Pairs{resolved[0]["a"].get<std::string>() + " " + resolved[0]["b"].get<std::string>()}), Pairs{"b e"});
    EXPECT_EQ(resolved[0]["kind"], "enclosed");
    EXPECT_NE(folder_.read("r.html").find("Resolved since the baseline (1)"), std::string::npos);
}

TEST_F(ClashCommand, WarnsOfABaselineWithALargerClearance)
{
    clash({"--clearance", "1", "-o", "old.json"});
    const auto warned = [&](const char* clearance) {
        return clash({"--clearance", clearance, "--baseline", "old.json"})
            .err.find("old.json: has a clearance of 1 mm");
    };
    EXPECT_NE(warned("0.5"), std::string::npos);
    EXPECT_EQ(warned("0.1cm"), std::string::npos);
}

TEST_F(ClashCommand, NamesInCsvAreNoFormulasOfASpreadsheet)
{
    const std::vector<std::string> names{"=HYPERLINK(1)", "+1", "-1", "@SUM(1)", "'quoted"};
    std::vector<std::string> arguments{"clash"};
    for (const std::string& name : names)
        write_box("./" + name + ".off", {0, 0, 0}, {1, 1, 1}), arguments.push_back("./" + name + ".off");
    arguments.insert(arguments.end(), {"--units", "m"});
    const auto with = [&](std::vector<std::string> more) {
        more.insert(more.begin(), arguments.begin(), arguments.end());
        return run(more);
    };
    EXPECT_EQ(with({"-o", "r.csv", "-o", "r.json"}).code, 1);
    const std::string csv = folder_.read("r.csv");
    for (const char* field : {"'=HYPERLINK(1),", "'+1,", "'-1,", "'@SUM(1),", "'quoted,"})
        EXPECT_NE(csv.find(field), std::string::npos) << field << "\n" << csv;
    for (const char* formula : {"\n=", ",=", "\n+", ",+", "\n@", ",@"})
        EXPECT_EQ(csv.find(formula), std::string::npos) << csv;
    EXPECT_EQ(folder_.read("r.json").find("\"'="), std::string::npos) << "JSON keeps names";
    const Outcome again = with({"--ignore", "r.csv", "-o", "again.json"});
    EXPECT_EQ(again.code, 0) << again.out << again.err;
    EXPECT_EQ(again.err.find("no part is named"), std::string::npos) << again.err;
}

TEST_F(ClashCommand, PartsOfAGroupAreNotCompared)
{
    EXPECT_EQ(clash({"--group", "[", "--group", "?", "-o", "r.json"}).code, 64) << "none is left";
    clash({"--group", "e", "--group", "file", "-o", "r.json"});
    EXPECT_EQ(pairs("r.json").size(), 3u);
    clash({"--group", "a", "--group", "b", "--group", "a", "-o", "r.json"});
    EXPECT_EQ(pairs("r.json").size(), 3u);
    const json c = read_json("r.json")["clashes"][1];
    EXPECT_EQ(c["a"]["group"], "a");
    EXPECT_EQ(clash({"--group", "[ab]", "--quiet", "--group", "*"}).out, "");
}

TEST_F(ClashCommand, FoldersAreReadWithAllThatIsInThem)
{
    std::filesystem::create_directories(folder_ / "parts/left");
    write_box("parts/bolt.off", {0, 0, 0}, {1, 1, 1});
    write_box("parts/left/bolt.off", {0.5, 0, 0}, {2, 1, 1});
    folder_.write("parts/notes.txt", "no mesh");
    const Outcome outcome = run({"clash", "parts", "-o", "r.json"});
    EXPECT_EQ(outcome.code, 1) << outcome.err;
    EXPECT_EQ(pairs("r.json"), (Pairs{"parts/bolt.off parts/left/bolt.off crossing new"}));
    EXPECT_NE(outcome.err.find("warning: 2 parts are named 'bolt'; the report names them 'parts/bolt.off', "
                               "'parts/left/bolt.off'"),
              std::string::npos)
        << outcome.err;
}

TEST_F(ClashCommand, OpenPartsAreNamed)
{
    folder_.write("sheet.off", "OFF\n4 2 0\n-5 -5 5\n5 -5 5\n5 5 5\n-5 5 5\n3 0 1 2\n3 0 2 3\n");
    write_box("a.off", {0, 0, 0}, {10, 10, 10});
    const Outcome outcome = run({"clash", "a.off", "sheet.off", "-o", "r.json"});
    EXPECT_EQ(outcome.code, 1);
    EXPECT_NE(outcome.out.find("1 part is not closed ('sheet': 4 open edges, 40 mm long)"), std::string::npos)
        << outcome.out;
    EXPECT_EQ(read_json("r.json")["clashes"][0]["thickness"], nullptr);
    EXPECT_EQ(read_json("r.json")["clashes"][0]["ball"], nullptr);
    EXPECT_EQ(read_json("r.json")["open"], json{"sheet"});
    EXPECT_EQ(read_json("r.json")["open_because"], json{"4 open edges, 40 mm long"});
}

TEST_F(ClashCommand, PartsThatMeetThemselvesAreNamedOnRequest)
{
    folder_.write("crossed.off", "OFF\n6 2 0\n0 0 0\n4 0 0\n0 4 0\n1 1 -1\n1 1 1\n2 1 1\n3 0 1 2\n3 3 4 5\n");
    write_box("a.off", {10, 10, 10}, {12, 12, 12});
    const Outcome outcome = run({"clash", "a.off", "crossed.off", "--self", "-o", "r.json"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("1 part meets itself: 'crossed' (1 pair of triangles, around 1.25 1 0)"),
              std::string::npos)
        << outcome.out;
    const json found = read_json("r.json")["self"];
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0]["name"], "crossed");
    EXPECT_EQ(found[0]["pairs"], 1);
    EXPECT_EQ(found[0]["triangles"], json({0, 1}));
    EXPECT_EQ(found[0]["where"], json({1.25, 1.0, 0.0}));
    write_box("b.off", {20, 10, 10}, {22, 12, 12});
    EXPECT_NE(run({"clash", "a.off", "b.off", "--self"}).out.find("no part meets itself"), std::string::npos);
    run({"clash", "a.off", "crossed.off", "-o", "r.json"});
    EXPECT_EQ(read_json("r.json")["self"], nullptr);
}

TEST_F(ClashCommand, NamesHarmNoReport)
{
    const std::vector<std::string> names{"<script>alert(1)</script>.off", "a,\"b\"\n#.off", "]]>&'.off",
                                         "\xff\xfe.off"};
    std::filesystem::create_directory(folder_ / "n");
    for (const std::string& name : names) {
        std::string safe = name;
        for (char& c : safe)
            if (c == '/') c = '_'; // not valid in a file name
        write_box("n/" + safe, {0, 0, 0}, {1, 1, 1});
    }
    const Outcome outcome =
        run({"clash", "n", "-o", "r.json", "-o", "r.csv", "-o", "r.xml", "-o", "r.html", "--pictures", "0"});
    EXPECT_EQ(outcome.code, 1) << outcome.err;
    EXPECT_EQ(read_json("r.json")["clashes"].size(), 6u);
    EXPECT_EQ(folder_.read("r.html").find("<script>alert"), std::string::npos);
    const std::string xml = folder_.read("r.xml");
    EXPECT_EQ(xml.find("<script>"), std::string::npos);
    EXPECT_EQ(std::ranges::count_if(xml, [](unsigned char c) { return c < 32 && c != '\n'; }), 0);
    // The baseline finds its names again, and a list of pairs finds the names that a row can hold.
    EXPECT_EQ(run({"clash", "n", "--baseline", "r.json"}).code, 0);
}

TEST_F(ClashCommand, MillimetresBesideMetresAreWarnedOf)
{
    write_box("frame.off", {0, 0, 0}, {1500, 900, 30});
    write_box("door.off", {0, 0, 31}, {1500, 900, 60});
    write_box("knob.off", {0.9, 0.4, 0.06}, {0.95, 0.45, 0.1});
    Outcome outcome = run({"clash", "frame.off", "door.off", "knob.off"});
    EXPECT_NE(outcome.err.find("warning: knob.off lies within 0.95 mm of the origin, all other files extend to 1500 mm "
                               "or more: metres mixed with millimetres? If so, give --units 'knob.off=m'"),
              std::string::npos)
        << outcome.err;
    outcome = run({"clash", "frame.off", "door.off", "knob.off", "--units", "knob.off=m"});
    EXPECT_EQ(outcome.err, "");
}

} // namespace
} // namespace oncollide::test
