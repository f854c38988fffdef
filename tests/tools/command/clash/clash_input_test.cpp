// oncollide clash: input that cannot be used, and files that are left out.
#include "clash/parts/name_pattern.hpp"
#include "tools/command/clash/clash_fixture.hpp"
#include "tools/csv_rows.hpp"
#include <oncollide/samples/generators.hpp>

namespace oncollide::test {
namespace {

using nlohmann::json;

TEST_F(ClashCommand, SaysWhatIsWrongWithItsInput)
{
    files_ = small_assembly();
    std::filesystem::create_directory(folder_ / "empty");
    expect_error(66, {"clash", "nothing.stl"}, {"nothing.stl"});
    expect_error(66, {"clash", "empty"}, {"empty", "no mesh file in this folder"});
    expect_error(65, {"clash", "a.off"}, {"only one part ('a')", "a folder"});
    expect_error(64, {"clash", "a.off", "./a.off"}, {"given twice"});
    expect_error(64, {"clash", "a.off", "b.off", "--units", "furlong"}, {"--units furlong", "valid: mm, cm, m, in"});
    expect_error(64, {"clash", "a.off", "b.off", "--units", "=m"}, {"PATTERN=UNIT"});
    for (const char* length : {"-1", "2 miles", "mm", "nan", "inf"})
        expect_error(64, {"clash", "a.off", "b.off", fmt::format("--clearance={}", length)},
                     {"--clearance", "expected a length"});
    expect_error(64, {"clash", "a.off", "b.off", "-o", "report.pdf"},
                 {"report.pdf", ".html, .json, .csv, .xml (JUnit), .bcf or .bcfzip"});
    expect_error(64, {"clash", "a.off", "b.off", "-o", "r.json", "-o", "./r.json"}, {"both go to"});
    expect_error(64, {"clash", "a.off", "b.off", "--pictures", "-1"}, {"--pictures"});
    folder_.write("known.csv", "a,b\n\na\n");
    expect_error(65, {"clash", "a.off", "b.off", "--ignore", "known.csv"}, {"known.csv: line 3: not two names"});
    folder_.write("known.csv", "\"a,b\n");
    expect_error(65, {"clash", "a.off", "b.off", "--ignore", "known.csv"}, {"known.csv: line 1", "no closing quote"});
    expect_error(64, {"clash", "a.off", "b.off", "--ignore", "known.csv", "-o", "known.csv"}, {"would overwrite"});
    for (const char* text : {"[]", "{", "{\"report\": \"oncollide clash\"}", "{\"report\": 3}",
                             "{\"report\": \"oncollide clash\", \"clashes\": [{}]}"}) {
        folder_.write("old.json", text);
        expect_error(65, {"clash", "a.off", "b.off", "--baseline", "old.json"}, {"old.json", "JSON report"});
        EXPECT_EQ(run({"clash", "a.off", "b.off", "--baseline", "old.json"}).err.find("json.exception"),
                  std::string::npos);
    }
    folder_.write("bad.off", "OFF\n1 1 0\n0 0 0\n3 0 1 2\n");
    expect_error(65, {"clash", "a.off", "bad.off", "b.off"}, {"bad.off"});
}

TEST_F(ClashCommand, FilesOfAFolderThatAreNotReadAreNamed)
{
    std::filesystem::create_directories(folder_ / "all/inner");
    write_box("all/a.off", {0, 0, 0}, {1, 1, 1});
    write_box("all/inner/b.off", {2, 0, 0}, {3, 1, 1});
    for (const char* name : {"all/c.pdf", "all/inner/d.txt", "all/a.mtl"}) folder_.write(name, "x");
    const Outcome outcome = run({"clash", "all", "-o", "r.json"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    const std::string line = "all: files that are no meshes are left out: c.pdf, inner/d.txt";
    EXPECT_EQ(outcome.err, "oncollide: warning: " + line + "\n");
    EXPECT_EQ(read_json("r.json")["warnings"], nlohmann::json::array({line}));
    EXPECT_EQ(run({"clash", "all", "--quiet"}).err, "");
    std::filesystem::create_directory(folder_ / "none");
    folder_.write("none/c.pdf", "x");
    expect_error(66, {"clash", "none"}, {"none: no mesh file in this folder", "other files: c.pdf"});
    expect_error(65, {"clash", "all/a.off", "all/c.pdf"}, {"all/c.pdf: unknown kind of mesh file '.pdf'"});
}

TEST_F(ClashCommand, AFileThatCannotBeReadIsNeverSilent)
{
    std::filesystem::create_directories(folder_ / "all");
    write_box("all/a.off", {0, 0, 0}, {1, 1, 1}), write_box("all/b.off", {2, 0, 0}, {3, 1, 1});
    for (const char* name : {"hall.RVT", "shaft.prt.12", "cover.SLDPRT", "plan.dwg", "model.nwd", "scene.fbx"}) {
        const std::string path = std::string("all/") + name;
        folder_.write(path, "x");
        const std::string words = path + ": files with the ending .";
        expect_error(66, {"clash", "all"}, {words, "export the parts as glTF (.glb)"});
        expect_error(66, {"clash", "all/a.off", "all/b.off", path}, {words});
        expect_error(66, {"check", "--self", "all", "--quiet"}, {words});
        std::filesystem::remove(folder_ / path);
    }
    folder_.write("all/plan.dwg", "x"), folder_.write("all/torn.off", "OFF\n1 1 0\n0 0 0\n3 0 1 2\n");
    expect_error(66, {"clash", "all"}, {"all/plan.dwg"}); // the first
    const Outcome outcome = run({"clash", "all", "--skip-unreadable", "-o", "r.json", "-o", "r.xml"});
    EXPECT_EQ(outcome.code, 2) << outcome.err;
    EXPECT_NE(outcome.out.find("2 files could not be read: clashes of their parts are missing\nno clashes\n"),
              std::string::npos)
        << outcome.out;
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 2) << outcome.err;
    EXPECT_NE(outcome.err.find("warning: all/torn.off: "), std::string::npos) << outcome.err;
    const json report = read_json("r.json");
    EXPECT_EQ(report["files"], (json{"all/a.off", "all/b.off"}));
    EXPECT_EQ(report["unreadable"].size(), 2u);
    EXPECT_EQ(report["parts"], 2);
    EXPECT_NE(folder_.read("r.xml").find("errors=\"2\""), std::string::npos);
    write_box("all/c.off", {0.5, 0, 0}, {1.5, 1, 1});
    EXPECT_EQ(run({"clash", "all", "--skip-unreadable"}).code, 1) << "a clash counts more";
    expect_error(66, {"clash", "all/plan.dwg", "--skip-unreadable"}, {"no file can be read"});
    expect_error(66, {"clash", "all/a.off", "absent.off"}, {"absent.off"});
    EXPECT_EQ(run({"clash", "all/a.off", "all/b.off", "absent.off", "--skip-unreadable"}).code, 2);
}

TEST_F(ClashCommand, RulesThatMatchNothingAreErrorsIfStrict)
{
    files_ = small_assembly();
    folder_.write("known.csv", "a,b\n\"a\",f\ne,f\n");
    const Outcome outcome = clash({"--ignore", "known.csv"});
    EXPECT_EQ(outcome.code, 1) << "b and e";
    EXPECT_EQ(outcome.err,
              "oncollide: warning: known.csv: 2 rows match no pair that meets: line 2 ('a' and 'f'), line 3 "
              "('e' and 'f')\n");
    std::vector<std::string> strict{"clash", "--strict"};
    strict.insert(strict.end(), files_.begin(), files_.end());
    const auto with = [&](std::vector<std::string> more) {
        more.insert(more.begin(), strict.begin(), strict.end());
        return more;
    };
    expect_error(65, with({"--ignore", "known.csv"}), {"known.csv: 2 rows match no pair that meets: line 2"});
    folder_.write("known.csv", "a,b\n");
    EXPECT_EQ(run(with({"--ignore", "known.csv"})).code, 1);
    expect_error(64, with({"--group", "bolt"}), {"--group 'bolt' matches no part", "the first part is 'a.off'"});
}

TEST_F(ClashCommand, MorePairsThanTheMemoryHoldsAreRefusedBeforehand)
{
    std::vector<std::string> arguments{"clash"};
    for (int i = 0; i < 8; ++i) {
        write_box(fmt::format("{}.off", i), {0, 0, 0}, {1, 1, 1});
        arguments.push_back(fmt::format("{}.off", i));
    }
    const auto with = [&](std::vector<std::string> more) {
        more.insert(more.begin(), arguments.begin(), arguments.end());
        return more;
    };
    expect_error(65, with({"--max-pairs", "27"}),
                 {"0.off: the AABBs of more than 27 pairs of parts overlap", "--max-pairs"});
    EXPECT_EQ(run(with({"--max-pairs", "28"})).code, 1);
    EXPECT_EQ(run(with({"--max-pairs", "7", "--set-a", "3"})).code, 1) << "only pairs that are compared count";
    EXPECT_EQ(run(with({"--max-pairs", "7", "--group", "0", "--group", "?"})).code, 1)
        << "part 0 and the group of the others";
    expect_error(64, with({"--max-pairs", "0"}), {"--max-pairs"});
    expect_error(64, with({"--max-parts", "0"}), {"--max-parts"});
}

TEST(NamePatterns, StarsAndQuestionMarks)
{
    using tools::matches;
    EXPECT_TRUE(matches("bolt*", "bolt-7") && matches("*", "") && matches("b?lt", "bolt") &&
                matches("a*b*c", "aXbYbZc"));
    EXPECT_FALSE(matches("bolt", "bolt-7") || matches("b?lt", "blt") || matches("", "a") || matches("a*b", "acbc"));
    EXPECT_TRUE(matches("a\\*", "a*") && !matches("a\\*", "ab") && matches("\\", "\\"));
    EXPECT_FALSE(matches(std::string(40, '*') + "x", std::string(4000, 'a'))) << "and soon";
}

} // namespace
} // namespace oncollide::test
