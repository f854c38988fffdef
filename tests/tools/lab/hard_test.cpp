#include "tools/command_fixture.hpp"
#include "verify/trials/hard_trials.hpp"

namespace oncollide::test {
namespace {

TEST(HardTriangles, AreTheSameForAnyNumberOfThreads)
{
    for (const TriangleFamily& family : triangle_families())
        for (bool rotated : {false, true}) {
            const tools::Tally one = tools::try_triangles(family, 600, rotated, 1),
                               two = tools::try_triangles(family, 600, rotated, 2);
            EXPECT_EQ(one.faults(), 0u) << one.family << ": " << one.first_fault;
            EXPECT_EQ(one.results, 1800u);
            EXPECT_EQ(two.results, one.results);
        }
}

TEST_F(CommandLine, HardWritesATableOfFamilies)
{
    const Outcome outcome = run({"hard", "--count", "2000", "--family", "vertex on face", "--family", "touching boxes",
                                 "--csv", "hard.csv", "--json", "hard.json", "--threads", "2"});
    ASSERT_EQ(outcome.code, 0) << outcome.out << outcome.err;
    EXPECT_NE(outcome.out.find("no collision missed"), std::string::npos) << outcome.out;
    const nlohmann::json rows = read_json("hard.json")["families"];
    ASSERT_EQ(rows.size(), 3u);
    EXPECT_EQ(rows[0]["family"], "vertex on face");
    EXPECT_EQ(rows[1]["family"], "vertex on face, turned");
    EXPECT_EQ(rows[2]["family"], "touching boxes");
    for (const nlohmann::json& row : rows)
        for (const char* fault : {"missed", "wrong", "bounds_broken", "changed"}) EXPECT_EQ(row[fault], 0) << row;
    EXPECT_EQ(rows[0]["cases"], 2000);
    EXPECT_GT(rows[2]["bounds"], 10000);
    const std::string csv = folder_.read("hard.csv");
    EXPECT_TRUE(csv.starts_with("family,cases,answers,missed,wrong,")) << csv;
    EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 4);
}

/// Spheres, capsules and triangles against cells, boxes, hulls and meshes, and all of these against terrains.
TEST_F(CommandLine, HardFindsNoFaultWhereBodiesAreTangent)
{
    const std::vector<std::string> families{"balls on faces of cells and boxes",
                                            "balls on edges of cells and boxes",
                                            "balls on corners of cells and boxes",
                                            "capsules along edges",
                                            "triangles on cells",
                                            "balls on terrain",
                                            "capsules on terrain",
                                            "boxes on terrain",
                                            "triangles on terrain",
                                            "half-spaces on terrain",
                                            "terrain on terrain",
                                            "terrain that is off"};
    const auto rows = [&](const char* threads) {
        std::vector<std::string> command{"hard", "--count", "10000", "--threads", threads, "--json", "h.json"};
        for (const std::string& family : families) command.insert(command.end(), {"--family", family});
        const Outcome outcome = run(command);
        EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
        return read_json("h.json")["families"];
    };
    const nlohmann::json found = rows("1");
    ASSERT_EQ(found.size(), families.size());
    for (std::size_t i = 0; i < families.size(); ++i) {
        SCOPED_TRACE(families[i]);
        const nlohmann::json& row = found[i];
        EXPECT_EQ(row["family"], families[i]);
        EXPECT_EQ(row["cases"], 200) << "a fiftieth";
        EXPECT_EQ(row["answers"], families[i] == "terrain that is off" ? 600 : 800);
        for (const char* fault : {"missed", "wrong", "bounds_broken", "changed"}) EXPECT_EQ(row[fault], 0) << fault;
    }
    EXPECT_GT(found.back()["bounds"], 1000);
    EXPECT_EQ(rows("3"), found);
}

TEST_F(CommandLine, HardReadsErlebensQueries)
{
    std::filesystem::create_directories(folder_.path() / "queries");
    for (const char* kind : {"erleben-spikes", "erleben-wedges", "erleben-cube-internal-edges"}) {
        std::filesystem::create_directory(folder_.path() / "queries" / kind);
        const std::string folder = fmt::format("queries/{}/", kind);
        // A corner above a face at t0 and on it at t1; two edges apart, then crossing.
        folder_.write(folder + "vertex-face.csv", "1,2,1,4,1,1,1\n0,1,0,1,0,1,1\n1,1,0,1,0,1,1\n0,1,1,1,0,1,1\n"
                                                  "1,2,1,4,0,1,1\n0,1,0,1,0,1,1\n1,1,0,1,0,1,1\n0,1,1,1,0,1,1\n");
        folder_.write(folder + "edge-edge.csv", "-1,1,0,1,1,1,1\n1,1,0,1,1,1,1\n0,1,-1,1,0,1,1\n0,1,1,1,0,1,1\n"
                                                "-1,1,0,1,0,1,1\n1,1,0,1,0,1,1\n0,1,-1,1,0,1,1\n0,1,1,1,0,1,1\n");
    }
    const std::vector<std::string> command{"hard",      "--family", "Erleben's wedges",     "--json",
                                           "hard.json", "--data",   folder_.path().string()};
    const Outcome outcome = run(command);
    ASSERT_EQ(outcome.code, 0) << outcome.out << outcome.err;
    const nlohmann::json rows = read_json("hard.json")["families"];
    ASSERT_EQ(rows.size(), 1u);
    EXPECT_EQ(rows[0]["cases"], 4);
    folder_.write("queries/erleben-wedges/edge-edge.csv", "1,2,3\n");
    expect_error(65, command, {"erleben-wedges/edge-edge.csv: line 1", "seven numbers"});
    folder_.write("queries/erleben-wedges/edge-edge.csv", "0,1,0,1,0,1,0\n");
    expect_error(65, command, {"erleben-wedges/edge-edge.csv", "within a query"});
}

TEST_F(CommandLine, HardRefusesWhatMakesNoSense)
{
    expect_error(64, {"hard", "--family", "spheres"},
                 {"'spheres'", "coplanar", "touching boxes", "triangles on cells", "boxes on terrain"});
    expect_error(64, {"hard", "--count", "0"}, {"--count 0", "at least 1"});
    expect_error(64, {"hard", "--threads", "-1"}, {"--threads -1"});
    expect_error(64, {"hard", "--csv", "x", "--json", "x"}, {"both go to 'x'"});
    expect_error(64, {"hard", "paper"}, {"unexpected argument 'paper'"});
    expect_error(73, {"hard", "--csv", "no/where.csv"}, {"no/where.csv"});
}

} // namespace
} // namespace oncollide::test
