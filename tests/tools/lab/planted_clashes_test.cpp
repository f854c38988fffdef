// Assemblies with planted clashes: all are found, and none is invented.
#include <algorithm>

#include "clash/parts/file_list.hpp"
#include "clash/parts/units.hpp"
#include "planted/planted_assembly.hpp"
#include "tools/command/clash/clash_fixture.hpp"
#include "tools/csv_rows.hpp"

namespace oncollide::test {
namespace {

using nlohmann::json;
using tools::Clash;
using tools::ClashKind;

/// An assembly on disk, in both forms.
class PlantedClashes : public ::testing::Test {
protected:
    static std::vector<std::string> faults(const tools::PlantedAssembly& planted, const std::vector<std::string>& files,
                                           int threads, std::vector<Clash>& list)
    {
        const tools::PartList parts = tools::read_parts(files, tools::Units({"mm"}), {}, threads);
        const tools::Clashes found = tools::find_clashes(parts, {.clearance = 2, .threads = threads});
        list = found.list;
        return tools::faults_of(planted, parts, list);
    }
    TemporaryFolder folder_;
};

TEST_F(PlantedClashes, OfEveryKindAreAllFoundAndNoneIsInvented)
{
    const tools::PlantedAssembly planted =
        tools::make_planted_assembly({.parts = 520, .triangles = 300, .meshes = {}, .every = 2});
    ASSERT_EQ(planted.parts.size(), 520u);
    std::map<ClashKind, int> kinds;
    for (const auto& pair : planted.pairs) ++kinds[pair.kind];
    ASSERT_EQ(kinds.size(), 5u);
    for (const auto& [kind, count] : kinds) ASSERT_GE(count, 10) << name_of(kind);

    std::filesystem::create_directory(folder_ / "stl");
    tools::write_stl_files(planted, folder_ / "stl");
    tools::write_glb_file(planted, folder_ / "all.glb");
    std::vector<Clash> list, again;
    for (const auto& files : {tools::files_of({(folder_ / "stl").string()}), {(folder_ / "all.glb").string()}})
        EXPECT_EQ(faults(planted, files, 1, list), std::vector<std::string>());
    EXPECT_EQ(faults(planted, {(folder_ / "all.glb").string()}, 4, again), std::vector<std::string>());
    ASSERT_EQ(again.size(), list.size());
    for (std::size_t i = 0; i < list.size(); ++i) {
        EXPECT_EQ(again[i].a, list[i].a);
        EXPECT_EQ(again[i].reach.depth, list[i].reach.depth) << "independent of the thread count";
        EXPECT_EQ(again[i].upper, list[i].upper);
    }

    // The judge detects planted faults.
    const tools::PartList parts = tools::read_parts({(folder_ / "all.glb").string()}, tools::Units({"mm"}), {}, 1);
    std::vector<Clash> wrong = list;
    wrong.pop_back();
    EXPECT_EQ(tools::faults_of(planted, parts, wrong).size(), 1u);
    wrong = list, wrong[0].kind = ClashKind::near;
    EXPECT_GE(tools::faults_of(planted, parts, wrong).size(), 1u);
    wrong = list, wrong.push_back(wrong.front());
    EXPECT_EQ(tools::faults_of(planted, parts, wrong).size(), 1u);
    wrong = list;
    for (Clash& c : wrong) c.reach.depth *= 1.02;
    EXPECT_GE(tools::faults_of(planted, parts, wrong).size(), 10u);
}

TEST_F(PlantedClashes, AGlbOfNodesWithOneNameIsToldApart)
{
    tools::PlantedAssembly twice = tools::make_planted_assembly({.parts = 4, .triangles = 100, .meshes = {}});
    for (auto& part : twice.parts) part.name = "part";
    tools::write_glb_file(twice, folder_ / "all.glb");
    folder_.write("other.off", "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n");
    const tools::PartList parts = tools::read_parts({(folder_ / "all.glb").string(), (folder_ / "other.off").string()},
                                                    tools::Units({"mm"}), {.groups = {"node"}}, 1);
    std::set<std::string> names;
    for (const tools::Part& part : parts.parts) names.insert(part.name);
    EXPECT_EQ(names, (std::set<std::string>{"assembly/part", "assembly/part (2)", "assembly/part (3)",
                                            "assembly/part (4)", "other"}));
    EXPECT_EQ(std::ranges::count_if(parts.warnings,
                                    [](const std::string& warning) {
                                        return warning.find("4 parts are named 'part'") != std::string::npos;
                                    }),
              1);
    EXPECT_EQ(parts.groups, (std::vector<std::string>{"", "assembly"}));
}

TEST_F(PlantedClashes, AnAssemblyRunsAsAScene)
{
    tools::PlantedAssembly planted =
        tools::make_planted_assembly({.parts = 40, .triangles = 100, .meshes = {}, .every = 2});
    planted.parts[3].name = planted.parts[0].name;
    tools::write_glb_file(planted, folder_ / "all.glb");
    const Outcome outcome = run_program(
        ONCOLLIDE_COMMAND, {"run", "all.glb", "--exact", "predicates", "--mode", "solid", "--json", "r.json"},
        {.folder = folder_.path()});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    std::set<std::pair<std::string, std::string>> expected, found;
    for (const auto& pair : planted.pairs)
        if (pair.kind != ClashKind::near) expected.insert(std::minmax(pair.a, pair.b));
    const json results = json::parse(folder_.read("r.json"));
    EXPECT_EQ(results["header"]["bodies"], 40);
    const json& pairs = results["frames"][0]["pairs"];
    for (const json& pair : pairs)
        if (pair[2] == "colliding") found.insert(std::minmax(pair[0].get<std::string>(), pair[1].get<std::string>()));
    EXPECT_EQ(found, expected);
    // It is also written as a scene file.
    const auto written = [&](const std::string& out) {
        return run_program(ONCOLLIDE_COMMAND, {"scene", "all.glb", "--out", out}, {.folder = folder_.path()});
    };
    EXPECT_EQ(written("all.json").code, 0);
    EXPECT_EQ(written("all.glb").code, 64);
    run_program(ONCOLLIDE_COMMAND, {"run", "all.json", "--exact", "predicates", "--mode", "solid", "--json", "w.json"},
                {.folder = folder_.path()});
    EXPECT_EQ(json::parse(folder_.read("w.json"))["header"]["hash"], results["header"]["hash"]);
}

TEST_F(PlantedClashes, TheBenchmarkFindsNoFaultInMadeAndRealParts)
{
    const Surroundings around{.folder = folder_.path()};
    std::vector<std::string> arguments{"bench", "clash",      "--parts", "90",      "--triangles", "200",   "--every",
                                       "2",     "--pictures", "2",       "--write", "kept",        "--csv", "c.csv"};
    Outcome outcome = run_program(ONCOLLIDE_LAB, arguments, around);
    EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
    EXPECT_EQ(read_csv(folder_.read("c.csv")).size(), 2u);
    EXPECT_TRUE(std::filesystem::exists(folder_ / "kept/report.html"));
    const char* named = std::getenv("ONCOLLIDE_DATA");
    const std::filesystem::path data = named && *named ? named : ONCOLLIDE_SOURCE_DIR "/../shared/data";
    if (!std::filesystem::is_directory(data)) return; // generated parts only
    arguments.insert(arguments.end(), {"--real", "--data", std::filesystem::absolute(data)});
    outcome = run_program(ONCOLLIDE_LAB, arguments, around);
    EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
}

using PlantedReports = ClashCommand;

TEST_F(PlantedReports, PathsNameFilesAndAllNodes)
{
    tools::write_glb_file(tools::make_planted_assembly({.parts = 40, .triangles = 100, .meshes = {}, .every = 2}),
                          folder_ / "all.glb");
    run({"clash", "all.glb", "--set-a", "all.glb:assembly/crate*", "-o", "r.json"});
    nlohmann::json report = read_json("r.json");
    ASSERT_FALSE(report["clashes"].empty());
    for (const auto& clash : report["clashes"]) {
        const std::string a = clash["a"]["path"], b = clash["b"]["path"];
        EXPECT_TRUE(a.starts_with("all.glb:assembly/") && b.starts_with("all.glb:assembly/")) << a << b;
        EXPECT_TRUE(a.starts_with("all.glb:assembly/crate") || b.starts_with("all.glb:assembly/crate")) << a << b;
    }
    std::filesystem::create_directories(folder_ / "parts/left");
    write_box("parts/bolt.off", {0, 0, 0}, {1, 1, 1}), write_box("parts/left/bolt.off", {0.5, 0, 0}, {2, 1, 1});
    run({"clash", "parts/", "--set-a", "left/*", "-o", "r.json"});
    report = read_json("r.json");
    EXPECT_EQ(report["clashes"][0]["a"]["path"], "left/bolt.off") << "the side of set A";
    EXPECT_EQ(report["clashes"][0]["b"]["path"], "bolt.off");
}

} // namespace
} // namespace oncollide::test
