#include "command_fixture.hpp"

#include <sstream>

namespace oncollide::test {
namespace {

TEST_F(CommandLine, PartsOfARunMergeToTheFileOfTheWhole)
{
    const std::vector<std::string> scene{"run", "boxes", "--bodies", "200", "--frames", "7", "--quiet", "--csv"};
    const auto play = [&](std::vector<std::string> more) {
        std::vector<std::string> arguments = scene;
        arguments.insert(arguments.end(), more.begin(), more.end());
        const Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.code, 0) << outcome.err;
    };
    play({"whole.csv"});
    for (const int parts : {2, 3, 9}) { // with 9, two parts have no frame
        std::vector<std::string> merge{"merge", "--out", "merged.csv"};
        for (int part = parts; part >= 1; --part) {
            const std::string file = fmt::format("{}of{}.csv", part, parts);
            play({file, "--shard", fmt::format("{}/{}", part, parts)});
            merge.push_back(file);
        }
        ASSERT_EQ(run(merge).code, 0);
        EXPECT_EQ(folder_.read("merged.csv"), folder_.read("whole.csv")) << parts;
    }
    expect_error(66, {"merge", "1of3.csv", "3of3.csv", "--out", "m.csv"}, {"missing", "2/3"});
    expect_error(65, {"merge", "1of3.csv", "1of3.csv", "--out", "m.csv"}, {"part 1"});
    expect_error(65, {"merge", "1of3.csv", "2of9.csv", "--out", "m.csv"}, {"2of9.csv", "9 parts"});
    expect_error(65, {"merge", "whole.csv", "--out", "m.csv"}, {"whole.csv", "not a part"});
    expect_error(64, {"merge", "1of2.csv", "2of2.csv", "--out", "1of2.csv"}, {"overwrite"});
    play({"other.csv", "--shard", "2/2", "--clearance", "1"});
    expect_error(65, {"merge", "1of2.csv", "other.csv", "--out", "m.csv"}, {"different run"});
    for (const char* wrong : {"0/2", "3/2", "1/0", "1", "a/b", "1/2x"})
        expect_error(64, {"run", "boxes", "--shard", wrong}, {"--shard", "I/N"});
    expect_error(64, {"run", "boxes", "--shard", "1/2", "--checkpoint", "c"}, {"--shard"});
}

TEST_F(CommandLine, PartsOfTheHardCasesMergeToTheFileOfTheWhole)
{
    const std::vector<std::string> work{"accuracy", "hard",     "--count", "20",   "--family",
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

TEST_F(CommandLine, ARunWithCheckpointsIsThatWithoutThem)
{
    const std::vector<std::string> scene{"run", "boxes", "--bodies", "200", "--frames", "7", "--csv"};
    const auto play = [&](std::vector<std::string> more) {
        std::vector<std::string> arguments = scene;
        arguments.insert(arguments.end(), more.begin(), more.end());
        return run(arguments);
    };
    const auto hash = [](const Outcome& outcome) {
        const std::size_t begin = outcome.out.rfind("hash");
        return outcome.out.substr(begin, outcome.out.find('\n', begin) - begin);
    };
    const Outcome plain = play({"plain.csv"}),
                  kept = play({"kept.csv", "--checkpoint", "c", "--checkpoint-every", "3"});
    ASSERT_EQ(plain.code, 0) << plain.err;
    ASSERT_EQ(kept.code, 0) << kept.err;
    EXPECT_EQ(hash(kept), hash(plain));
    EXPECT_EQ(folder_.read("kept.csv"), folder_.read("plain.csv"));
    EXPECT_EQ(folder_.list(), (std::vector<std::string>{"c.0", "c.1", "kept.csv", "plain.csv"}));
    expect_error(64, {"run", "boxes", "--resume"}, {"--checkpoint"});
    expect_error(66, {"run", "boxes", "--resume", "--checkpoint", "none"}, {"none.0", "no checkpoint"});
    expect_error(64, {"run", "boxes", "--checkpoint", "c", "--json", "r.json"}, {"--json", "--csv"});
    expect_error(64, {"run", "boxes", "--checkpoint", "c", "--csv", "-"}, {"regular file"});
    expect_error(64, {"run", "boxes", "--checkpoint", "c", "--memory-budget", "1M"}, {"--memory-budget"});
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

#ifndef ONCOLLIDE_MPI
TEST_F(CommandLine, ManyProcessesWithoutMpiAreOneError)
{
    const auto as_process = [&](const char* rank) {
        return run({"run", "boxes"},
                   {.folder = {}, .environment = {{"OMPI_COMM_WORLD_SIZE", "2"}, {"OMPI_COMM_WORLD_RANK", rank}}});
    };
    const Outcome first = as_process("0"), second = as_process("1");
    EXPECT_EQ(first.code, 64);
    EXPECT_NE(first.err.find("ONCOLLIDE_MPI=ON"), std::string::npos) << first.err;
    EXPECT_EQ(second.code, 64);
    EXPECT_EQ(second.err, "");
}
#endif

} // namespace
} // namespace oncollide::test
