#include "tools/command_fixture.hpp"

#include "tools/csv_rows.hpp"

namespace oncollide::test {
namespace {

TEST_F(CommandLine, BenchShapesRefusesWhatMakesNoSense)
{
    expect_error(64, {"bench", "shapes", "--pairs", "0"}, {"--pairs 0", "from 1 to"});
    expect_error(64, {"bench", "shapes", "--pairs", "some"}, {"--pairs", "some"});
    for (const char* gap : {"0", "-1", "0.2", "nan"})
        expect_error(64, {"bench", "shapes", fmt::format("--least-gap={}", gap)}, {"--least-gap", "at most 0.1"});
    expect_error(64, {"bench", "shapes", "--threads", "-1"}, {"--threads -1", "from 0 to 1024"});
    expect_error(73, {"bench", "shapes", "--csv", "no/where.csv"}, {"no/where.csv"});
    std::filesystem::create_directory(folder_ / "folder.csv");
    expect_error(73, {"bench", "shapes", "--csv", "folder.csv"}, {"folder.csv"});
}

TEST_F(CommandLine, BenchShapesFindsNoWrongAnswerOfAnyTwoKinds)
{
    const auto hash = [&](const char* threads) {
        const Outcome outcome =
            run({"bench", "shapes", "--pairs", "3000", "--seed", "7", "--threads", threads, "--csv", "s.csv"});
        EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
        EXPECT_EQ(outcome.err, "");
        const std::size_t at = outcome.out.find("hash ");
        EXPECT_NE(at, std::string::npos) << outcome.out;
        return outcome.out.substr(std::min(at, outcome.out.size()));
    };
    EXPECT_EQ(hash("1"), hash("3"));
    const auto rows = read_csv(folder_.read("s.csv"));
    EXPECT_EQ(rows.size(), 35u) << "two of eight kinds each, except two half-spaces";
    int pairs = 0, colliding = 0;
    for (auto row : rows) {
        SCOPED_TRACE(row["a"] + " " + row["b"]);
        EXPECT_EQ(row["wrong"], "0");
        EXPECT_LE(std::stoi(row["colliding"]) + std::stoi(row["within"]), std::stoi(row["pairs"]));
        for (const char* column : {"oncollide_ns", "fcl_ns"}) EXPECT_GT(std::stod(row[column]), 0) << column;
        for (const char* column : {"fcl_lost", "fcl_made", "fcl_worst_m"}) EXPECT_GE(std::stod(row[column]), 0);
        pairs += std::stoi(row["pairs"]), colliding += std::stoi(row["colliding"]);
    }
    EXPECT_EQ(pairs, 3000);
    EXPECT_GT(colliding, 1000);
    EXPECT_LT(colliding, 2000);
}

} // namespace
} // namespace oncollide::test
