#include "tools/command_fixture.hpp"
#include "tools/csv_rows.hpp"

namespace oncollide::test {
namespace {

TEST_F(CommandLine, BenchManyFindsTheContactsThatFclFinds)
{
    expect_error(64, {"bench", "many", "--exact", "off", "--contacts"}, {"--contacts", "--exact predicates"});
    const Outcome outcome = run({"bench", "many", "--bodies", "60", "--frames", "3", "--warm-up", "1", "--exact",
                                 "predicates", "--contacts", "--threads", "2"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const std::size_t at = outcome.out.find("contacts   FCL ");
    ASSERT_NE(at, std::string::npos) << outcome.out;
    const auto number = [&](std::size_t from) {
        std::string digits;
        for (char c : outcome.out.substr(from, outcome.out.find_first_of(" \n", from) - from))
            if (std::isdigit(static_cast<unsigned char>(c)) || c == '.') digits += c;
        return std::stod(digits);
    };
    const double fcl = number(at + 15), ours = number(outcome.out.find("oncollide ", at) + 10);
    EXPECT_GT(ours, 100);
    EXPECT_NEAR(ours, fcl, 0.01 * fcl) << outcome.out;
    EXPECT_NE(outcome.out.find("bytes per triangle"), std::string::npos);
}

TEST_F(CommandLine, BenchWorldEndsWithTheResultsOfANewWorld)
{
    const Outcome outcome = run(
        {"bench", "world", "--bodies", "300", "--changes", "9", "--frames", "2", "--exact", "on", "--csv", "w.csv"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("results    same as of a newly made World"), std::string::npos) << outcome.out;
    EXPECT_EQ(read_csv(folder_.read("w.csv")).size(), 4u);
}

TEST_F(CommandLine, BenchManyFindsFclsContactsWhereNothingMoves)
{
    const Outcome outcome =
        run({"bench", "many", "--bodies", "60", "--frames", "4", "--warm-up", "1", "--exact", "on", "--pace", "0"});
    EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
}

TEST_F(CommandLine, BenchRaysFindsNoWrongHit)
{
    const Outcome outcome =
        run({"bench", "rays", "--triangles", "5000", "--rays", "300", "--repeats", "1", "--csv", "r.csv"});
    EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
    int oncollide = 0;
    for (auto& row : read_csv(folder_.read("r.csv"))) {
        if (row["contender"].rfind("oncollide", 0) != 0) continue;
        ++oncollide;
        EXPECT_EQ(row["missed"] + row["invented"], "00") << row["geometry"] << " " << row["rays"];
        EXPECT_EQ(row["count"], "300");
        if (row["rays"] == "vertical" && row["geometry"].rfind("hills", 0) == 0) {
            EXPECT_EQ(row["hits"], "300");
        }
    }
    EXPECT_EQ(oncollide, 3 * 2 * 2 * 3)
        << "mesh, terrain and map; query and cast; alone and together; three kinds of segments";
    expect_error(64, {"bench", "rays", "--rays", "0"}, {"--rays 0"});
    expect_error(66, {"bench", "rays", "none.obj"}, {"none.obj"});
}

TEST_F(CommandLine, BenchContinuousIsRightWhereFclMisses)
{
    const Outcome outcome =
        run({"bench", "continuous", "--motions", "12", "--samples", "20", "--steps", "30", "--csv", "c.csv"});
    EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
    EXPECT_NE(outcome.out.find("0 of 12 results contradicted"), std::string::npos) << outcome.out;
    EXPECT_NE(outcome.out.find("articulated body: 15 links, "), std::string::npos) << outcome.out;
    EXPECT_NE(outcome.out.find("; 0 contradicted"), std::string::npos) << outcome.out;
    EXPECT_EQ(read_csv(folder_.read("c.csv")).size(), 4u);
    expect_error(64, {"bench", "continuous", "--tolerance", "0"}, {"--tolerance 0", "1e-12"});
    expect_error(66, {"bench", "continuous", "none.obj", "none.obj"}, {"none.obj"});
}

TEST_F(CommandLine, BenchSceneSumsUpARaceInOneRow)
{
    expect_error(64, {"bench", "scene", "tiles", "--cache", "cache"}, {"--cache", "--only oncollide"});
    expect_error(64, {"bench", "many", "--cold-runs", "0"}, {"--cold-runs 0", "from 1 to"});
    expect_error(73, {"bench", "many", "--bodies", "9", "--summary", "no/s.csv"}, {"no/s.csv"});
    const auto row_of = [&](const std::string& scene, const std::vector<std::string>& more) {
        std::vector<std::string> words{"bench",    "scene",   scene,       "--bodies",  "24",
                                       "--frames", "6",       "--warm-up", "2",         "--cold-runs",
                                       "1",        "--exact", "on",        "--summary", "s.csv"};
        words.insert(words.end(), more.begin(), more.end());
        const Outcome outcome = run(words);
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        return read_csv(folder_.read("s.csv")).at(0);
    };
    auto both = row_of("st-helens", {}), fcl = row_of("st-helens", {"--only", "fcl"});
    for (const char* column : {"fcl_first_ms", "fcl_ms", "fcl_mb", "first_ms", "ms", "slowest_ms", "process_mb"})
        EXPECT_GT(std::stod(both[column]), 0) << column;
    EXPECT_GE(std::stod(both["slowest_ms"]), std::stod(both["median_ms"]));
    EXPECT_EQ(both["bodies"] + both["frames"] + both["missed"], "2540");
    EXPECT_EQ(fcl["ms"] + fcl["first_ms"], "");
    EXPECT_EQ(fcl["colliding"], both["colliding"]);
    EXPECT_GT(std::stod(both["colliding"]), 0);
    auto disk = row_of("tiles", {"--only", "oncollide", "--cache", "cache"});
    EXPECT_GT(std::stod(disk["triangles"]), 1e5);
    EXPECT_GT(std::stod(disk["colliding"]), 0);
    EXPECT_EQ(disk["fcl_ms"], "");
}

} // namespace
} // namespace oncollide::test
