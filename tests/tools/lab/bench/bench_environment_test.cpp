#include "tools/command_fixture.hpp"

#include <cmath>
#include <set>

#include "tools/csv_rows.hpp"

namespace oncollide::test {
namespace {

TEST_F(CommandLine, BenchEnvironmentRefusesWhatDoesNotExistBeforeItStarts)
{
    const auto refused = [&](int code, std::vector<std::string> more, const std::vector<std::string>& words) {
        more.insert(more.begin(), {"bench", "environment"});
        expect_error(code, std::move(more), words);
    };
    refused(64, {"--environments", "building,moon"}, {"--environments moon", "hills-mesh", "st-helens"});
    refused(64, {"--bodies-of", "shapes,cars"}, {"--bodies-of cars", "meshes, shapes, both"});
    refused(64, {"--bodies", "0"}, {"--bodies 0", "from 1 to"});
    refused(64, {"--bodies", "many"}, {"--bodies", "many"});
    refused(64, {"--frames", "0"}, {"--frames 0", "from 1 to"});
    refused(64, {"--warm-up", "-1"}, {"--warm-up -1", "at least 0"});
    refused(64, {"--cold-runs", "0"}, {"--cold-runs 0", "from 1 to"});
    refused(64, {"--cells", "7"}, {"--cells 7", "from 8 to 20000"});
    refused(64, {"--threads", "-1"}, {"threads = -1"});
    for (const char* bad : {"x", "0", "-1", "inf", "nan", "0.1,", "1m"})
        refused(64, {fmt::format("--errors={}", bad)}, {fmt::format("--errors {}", bad), "above 0", "exact"});
    refused(64, {"--environments", "hills,campus"}, {"'campus'", "--data", "ONCOLLIDE_DATA"});
    refused(66, {"--environments", "hills,campus", "--data", "none"}, {"--data", "'none'"});
    refused(66, {"--environments", "hills,campus", "--data", "."}, {"octomap/fr_campus.bt", "no such file"});
    refused(66, {"--environments", "st-helens", "--data", "."}, {"terrain/SainteHelens.dem", "no such file"});
    refused(64, {"--csv", "x", "--plot", "x"}, {"both go to 'x'"});
    refused(73, {"--csv", "no/where.csv"}, {"no/where.csv"});
    refused(73, {"--plot", "no/where.svg"}, {"no/where.svg"});
}

TEST_F(CommandLine, BenchEnvironmentComparesTerrainsAtEveryError)
{
    const Outcome outcome = run({"bench",       "environment", "--environments", "hills,hills-mesh",
                                 "--bodies-of", "shapes,both", "--errors",       "0.1,exact",
                                 "--cells",     "24",          "--bodies",       "40",
                                 "--frames",    "4",           "--warm-up",      "1",
                                 "--csv",       "e.csv",       "--plot",         "e.svg"});
    ASSERT_EQ(outcome.code, 0) << outcome.out << outcome.err;
    EXPECT_EQ(outcome.err, "");
    EXPECT_EQ(outcome.out.find("MISSED"), std::string::npos) << outcome.out;
    const auto rows = read_csv(folder_.read("e.csv"));
    ASSERT_EQ(rows.size(), 8u);
    std::set<std::string> names;
    std::map<std::string, std::set<std::string>> hashes; // of the grid and of the same surface as a mesh
    for (auto row : rows) {
        const std::string name = row["environment"] + " " + row["bodies"] + " " + row["error"];
        SCOPED_TRACE(name);
        names.insert(name);
        hashes[row["bodies"] + row["error"]].insert(row["hash"]);
        for (const char* column : {"fcl_ms", "ms", "ratio", "fcl_first_ms", "first_ms", "fcl_mb", "process_mb"})
            EXPECT_GT(std::stod(row[column]), 0) << column;
        EXPECT_EQ(row["threads"], "1");
        EXPECT_EQ(row["missed"], "0");
        EXPECT_GT(std::stoi(row["pairs"]), 40);
        EXPECT_GE(std::stoi(row["left_over"]), std::stoi(row["colliding"]));
        if (row["error"] != "exact") continue;
        EXPECT_EQ(row["false_positives"], "0");
        EXPECT_GT(std::stoi(row["colliding"]), 20);
    }
    EXPECT_TRUE(names.contains("hills shapes 0.1") && names.contains("hills-mesh both exact"));
    for (const auto& [dial, found] : hashes) EXPECT_EQ(found.size(), 1u) << dial;

    const std::string svg = folder_.read("e.svg");
    EXPECT_TRUE(svg.starts_with("<svg") && svg.ends_with("</svg>\n"));
    for (const char* word : {"error, metres", ">exact<", "hills-mesh, both", "oncollide"})
        EXPECT_NE(svg.find(word), std::string::npos) << word;
}

TEST_F(CommandLine, BenchDistancesMeasuresTerrainsNearAndFar)
{
    for (const char* bad : {"x", "0", "-1", "nan", "1,", "20000"})
        expect_error(64, {"bench", "distances", fmt::format("--distances={}", bad)},
                     {fmt::format("--distances {}", bad), "percentages"});
    expect_error(64, {"bench", "distances", "--environments", "moon"}, {"--environments moon"});
    expect_error(64, {"bench", "distances", "--bodies", "0"}, {"--bodies 0"});
    expect_error(73, {"bench", "distances", "--csv", "no/where.csv"}, {"no/where.csv"});
    const Outcome outcome = run({"bench", "distances", "--environments", "hills,hills-mesh", "--cells", "24",
                                 "--bodies", "3", "--distances", "1,50,200", "--csv", "d.csv"});
    ASSERT_EQ(outcome.code, 0) << outcome.out << outcome.err;
    const auto rows = read_csv(folder_.read("d.csv"));
    ASSERT_EQ(rows.size(), 12u);
    std::map<std::string, std::string> metres; // of the grid and of the same surface as a mesh
    for (auto row : rows) {
        EXPECT_GT(std::stod(row["fcl_us"]), 0);
        EXPECT_GT(std::stod(row["us"]), 0);
        EXPECT_EQ(row["differ"], "0");
        std::string& same = metres[row["bodies"] + row["percent"]];
        if (!same.empty()) {
            EXPECT_NEAR(std::stod(row["metres"]), std::stod(same), 0.3 * std::stod(same));
        }
        same = row["metres"];
    }
    EXPECT_EQ(metres.size(), 6u);
}

TEST_F(CommandLine, BenchDistancesMeasuresShapesFromShapes)
{
    expect_error(64, {"bench", "distances", "--bodies-of", "solids"}, {"--bodies-of solids", "all-shapes"});
    expect_error(64, {"bench", "distances", "--tolerance=-1"}, {"--tolerance"});
    const Outcome outcome = run({"bench", "distances", "--environments", "sphere,cone", "--bodies-of", "all-shapes",
                                 "--bodies", "7", "--distances", "0.1,100", "--tolerance", "1e-6", "--csv", "s.csv"});
    ASSERT_EQ(outcome.code, 0) << outcome.out << outcome.err;
    const auto rows = read_csv(folder_.read("s.csv"));
    ASSERT_EQ(rows.size(), 4u);
    for (auto row : rows) {
        const double wanted = std::stod(row["percent"]) / 100 * std::sqrt(3); // both are a metre wide and high
        EXPECT_NEAR(std::stod(row["metres"]), wanted, 0.15 * wanted);
    }
}

} // namespace
} // namespace oncollide::test
