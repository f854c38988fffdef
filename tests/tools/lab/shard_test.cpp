// Parts of the laboratory's work, which `oncollide merge` joins; simulated ranks.
#include <sstream>

#include "tools/command_fixture.hpp"

namespace oncollide::test {
namespace {

TEST_F(CommandLine, PartsOfTheHardCasesMergeToTheFileOfTheWhole)
{
    const std::vector<std::string> work{"hard",     "--count",  "20",      "--family",
                                        "coplanar", "--family", "slivers", "--csv"};
    const auto judge = [&](std::vector<std::string> more) {
        std::vector<std::string> arguments = work;
        arguments.insert(arguments.end(), more.begin(), more.end());
        return run(arguments);
    };
    const Outcome whole = judge({"whole.csv"});
    ASSERT_EQ(whole.code, 0) << whole.err;
    for (const char* part : {"1/2", "2/2"}) ASSERT_EQ(judge({fmt::format("{}.csv", part[0]), "--shard", part}).code, 0);
    ASSERT_EQ(run({"merge", "2.csv", "1.csv", "--out", "merged.csv"}).code, 0);
    EXPECT_EQ(folder_.read("merged.csv"), folder_.read("whole.csv"));
}

/// Rows without the columns that differ between any two runs.
std::vector<std::string> without_times(const std::string& csv)
{
    std::vector<std::string> rows;
    std::vector<bool> kept;
    std::istringstream lines(csv);
    for (std::string line, field; std::getline(lines, line);) {
        std::istringstream fields(line);
        std::string row;
        for (std::size_t k = 0; std::getline(fields, field, ','); ++k) {
            if (rows.empty()) kept.push_back(field != "ms" && field.find("_ms") == std::string::npos);
            if (kept.at(k)) row += field + ",";
        }
        rows.push_back(row);
    }
    return rows;
}

TEST_F(CommandLine, PartsOfBenchmarksMergeToTheRowsOfTheWhole)
{
    using Words = std::vector<std::string>;
    for (const Words& bench :
         {Words{"bench", "scale", "--bodies", "5000", "--ranks", "10"},
          Words{"bench", "scene", "boxes", "--bodies", "60", "--frames", "7", "--only", "oncollide"}}) {
        SCOPED_TRACE(bench[1]);
        const auto play = [&](Words more) {
            more.insert(more.begin(), bench.begin(), bench.end());
            const Outcome outcome = run(more);
            EXPECT_EQ(outcome.code, 0) << outcome.err;
        };
        play({"--csv", "whole.csv"});
        for (const char* part : {"1", "2", "3"})
            play({"--csv", fmt::format("{}.csv", part), "--shard", fmt::format("{}/3", part)});
        ASSERT_EQ(run({"merge", "3.csv", "1.csv", "2.csv", "--out", "merged.csv"}).code, 0);
        const Words whole = without_times(folder_.read("whole.csv"));
        EXPECT_EQ(without_times(folder_.read("merged.csv")), whole);
        EXPECT_GT(whole.size(), 6u);
    }
    expect_error(64, {"bench", "scale", "--ranks", "4", "--shard", "1/5"}, {"--shard", "4 ranks"});
    expect_error(64, {"bench", "scale", "--ranks", "4,8", "--shard", "1/2"}, {"--shard"});
}

TEST_F(CommandLine, SimulatedRanksAddUpToTheSamePairsHoweverManyThereAre)
{
    const auto result = [&](const char* ranks, const char* sample) {
        const Outcome outcome =
            run({"bench", "scale", "--bodies", "30000", "--ranks", ranks, "--sample", sample, "--edge", "0.5"});
        EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
        return outcome.out.substr(outcome.out.find("\npairs"),
                                  outcome.out.rfind("\nprocess") - outcome.out.find("\npairs"));
    };
    const std::string one = result("1", "0");
    EXPECT_EQ(result("8", "0"), one);
    EXPECT_EQ(result("30", "0"), one);
    EXPECT_NE(result("30", "4"), one);
    const Outcome both = run({"bench", "scale", "--bodies", "30000", "--ranks", "8,30", "--edge", "0.5"});
    EXPECT_EQ(both.code, 0) << both.out;
    EXPECT_NE(both.out.find(one), both.out.rfind(one)) << "the same pairs with two numbers of ranks";
    expect_error(64, {"bench", "scale", "--bodies", "1e12"}, {"--bodies"});
}

} // namespace
} // namespace oncollide::test
