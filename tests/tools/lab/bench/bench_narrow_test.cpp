#include "tools/command_fixture.hpp"

#include <set>
#include <thread>

#include "tools/csv_rows.hpp"

namespace oncollide::test {
namespace {

TEST_F(CommandLine, BenchNarrowRefusesWhatDoesNotExistBeforeItStarts)
{
    write_cube("cube.off");
    expect_error(64, {"bench", "narrow", "--only", "walk-5,fcl"}, {"--only fcl", "walk-6", "fcl-obbrss"});
    expect_error(64, {"bench", "narrow", "--query", "bool"}, {"--query bool", "boolean, all, distance"});
    for (const char* bad : {"x", "", "1,", "-60", "nan", "5%"})
        expect_error(64, {"bench", "narrow", fmt::format("--distances={}", *bad ? bad : ",")}, {"--distances", "-50"});
    expect_error(64, {"bench", "narrow", "--count", "0"}, {"--count 0", "1 to"});
    expect_error(64, {"bench", "narrow", "--repeats", "0"}, {"--repeats 0", "1 to"});
    expect_error(64, {"bench", "narrow", "cube.off"}, {"cube.off", "second mesh"});
    expect_error(64, {"bench", "narrow", "--poses", "poses.txt"}, {"--poses poses.txt", "MESH_A MESH_B"});
    expect_error(64, {"bench", "narrow", "cube.off", "cube.off", "--poses"}, {"--poses", "own"});
    expect_error(64, {"bench", "narrow", "--poses", "--distances", "1"}, {"--distances"});
    expect_error(64, {"bench", "narrow", "--only", "walk-5", "--ask", "all"}, {"walk-5", "none", "all"});
    expect_error(64, {"bench", "narrow", "--csv", "x", "--plot", "x"}, {"both go to 'x'"});
    expect_error(66, {"bench", "narrow", "cube.off", "none.obj"}, {"none.obj"});
    expect_error(66, {"bench", "narrow", "--poses"}, {"bunny"});
    expect_error(73, {"bench", "narrow", "--csv", "no/where.csv"}, {"no/where.csv"});
    expect_error(73, {"bench", "narrow", "--plot", "no/where.svg"}, {"no/where.svg"});
}

TEST_F(CommandLine, BenchNarrowComparesEverybodyOnGeneratedMeshes)
{
    const std::vector<std::string> arguments{"bench",     "narrow", "--count", "3",     "--distances", "-5,0,2,30",
                                             "--repeats", "1",      "--csv",   "n.csv", "--plot",      "n.svg"};
    const Outcome outcome = run(arguments);
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("checked by"), std::string::npos) << outcome.out;
    EXPECT_EQ(outcome.err, "");
    std::map<std::string, std::set<std::string>> hashes; // of exact results, by kind of query and distance
    std::set<std::string> seen;
    for (auto& row : read_csv(folder_.read("n.csv"))) {
        SCOPED_TRACE(row["contender"] + " " + row["ask"] + " " + row["distance"]);
        seen.insert(row["contender"] + " " + row["ask"]);
        EXPECT_EQ(row["poses"], "3");
        EXPECT_EQ(row["colliding"], row["distance"] == "-5 %" ? "3" : row["distance"] == "0 %" ? "1" : "0");
        EXPECT_GT(std::stod(row["median_us"]), 0);
        if (row["promise"] == "approximate") continue;
        EXPECT_EQ(row["missed"], "0");
        if (row["promise"] != "exact") continue;
        EXPECT_EQ(row["extra"], "0");
        EXPECT_LT(std::stod(row["error"]), 1e-6);
        if (row["ask"] != "distance") hashes[row["ask"] + row["distance"]].insert(row["hash"]); // these are rounded
    }
    for (const char* who : {"walk-5 boolean", "walk-8 boolean", "fcl-obb all", "fcl-obbrss distance", "exact distance",
                            "near-1% boolean"})
        EXPECT_TRUE(seen.contains(who)) << who;
    for (const auto& [question, answers] : hashes) EXPECT_EQ(answers.size(), 1u) << question;

    const std::string svg = folder_.read("n.svg");
    EXPECT_TRUE(svg.starts_with("<svg") && svg.ends_with("</svg>\n"));
    for (const char* word : {"microseconds", ">30 %<", "boolean: knot-3-4 and knot-2-3", "distance: "})
        EXPECT_NE(svg.find(word), std::string::npos) << word;
}

TEST_F(CommandLine, BenchNarrowTakesSingleTrianglesAndLeavesOutThoseWithoutArea)
{
    folder_.write("one.off", "OFF\n4 2 0\n0 0 0\n1 0 0\n0 1 .3\n2 0 0\n3 0 1 2\n3 0 1 3\n");
    const Outcome outcome = run({"bench", "narrow", "one.off", "one.off", "--count", "20", "--distances=-1,0,10"});
    EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
    EXPECT_NE(outcome.out.find("one (1 triangle"), std::string::npos) << outcome.out;

    folder_.write("none.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n2 0 0\n3 0 1 2\n");
    expect_error(65, {"bench", "narrow", "one.off", "none.off"}, {"none", "zero-area", "no triangle"});
}

TEST_F(CommandLine, BenchNarrowReadsMeshesPosesAndTheirAnswers)
{
    write_cube("cube.off");
    const std::string rotated = "1 0 0 0 1 0 0 0 1 ";
    folder_.write("p.txt", "0 0 " + rotated + "0.75 0.1 0.2\n1 0.5 " + rotated + "2 0 0\n");
    folder_.write("p_expected.txt", "0 1 24\n1 0 0\n");
    const auto ask = [&](std::vector<std::string> more) {
        std::vector<std::string> all{"bench", "narrow",    "cube.off", "cube.off", "--poses",
                                     "p.txt", "--repeats", "1",        "--only",   "walk-6,fcl-obb"};
        all.insert(all.end(), more.begin(), more.end());
        return run(all);
    };
    const Outcome outcome = ask({"--query", "boolean", "--csv", "-"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("2 poses, 0 contradicted by the judge"), std::string::npos) << outcome.out;
    EXPECT_NE(outcome.out.find("within 50 %"), std::string::npos) << outcome.out;

    // Impossible expectations: every library that promises them must be reported.
    folder_.write("p_expected.txt", "0 1 24\n1 1 1\n");
    const Outcome missed = ask({"--ask", "boolean"});
    EXPECT_EQ(missed.code, 70);
    EXPECT_NE(missed.out.find("MISSED 1"), std::string::npos) << missed.out;
    EXPECT_NE(missed.out.find("1 contradicted"), std::string::npos) << missed.out;

    folder_.write("p.txt", "0 0 1 2 3\n");
    expect_error(65, {"bench", "narrow", "cube.off", "cube.off", "--poses", "p.txt"}, {"p.txt:1", "must have 14"});
}

TEST_F(CommandLine, BenchDeformFindsThePairsThatOthersFind)
{
    const Outcome outcome =
        run({"bench", "deform", "--triangles", "3000", "--frames", "3", "--repeats", "1", "--csv", "d.csv"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    std::size_t exact = 0;
    for (auto& row : read_csv(folder_.read("d.csv"))) {
        EXPECT_GT(std::stod(row["pairs"]), 100) << row["contender"];
        if (row["contender"] == "fcl-obb" || row["contender"].starts_with("embree")) {
            EXPECT_EQ(row["differ"], "0") << row["scene"] << " " << row["contender"];
        }
        if (row["contender"] != "oncollide") continue;
        ++exact;
        EXPECT_GT(std::stod(row["refitted_percent"]), 0.5);
        EXPECT_LT(std::stod(row["refitted_percent"]), row["scene"] == "two cloths" ? 100 : 10);
    }
    EXPECT_EQ(exact, 2u);
    expect_error(64, {"bench", "deform", "--frames", "0"}, {"--frames 0"});
}

TEST_F(CommandLine, BenchPlannerAgreesWithFcl)
{
    const Outcome outcome = run({"bench", "planner", "--poses", "400", "--csv", "p.csv"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("poses per s"), std::string::npos) << outcome.out;
    EXPECT_NE(outcome.out.find("FCL contradicts: 0"), std::string::npos) << outcome.out;
    const std::string csv = folder_.read("p.csv");
    EXPECT_NE(csv.find("\nterrain,69192,knot,5000,400,"), std::string::npos) << csv;
    EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 3 * std::min(2u, std::thread::hardware_concurrency()))
        << csv;
    expect_error(64, {"bench", "planner", "--poses", "0"}, {"--poses 0"});
    expect_error(66, {"bench", "planner", "none.obj", "none.obj"}, {"none.obj"});
}

} // namespace
} // namespace oncollide::test
