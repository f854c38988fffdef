#include "tools/command_fixture.hpp"

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
