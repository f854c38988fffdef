#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "temporary_folder.hpp"
#include <oncollide/base/error.hpp>
#include <oncollide/base/files/program_output.hpp>

namespace oncollide::program_output_test {
namespace {

using End = ProgramOutput::End;

class ProgramOutputs : public ::testing::Test {
protected:
    static ProgramOutput shell(const std::string& script, const ProgramLimits& limits = {})
    {
        return output_of("/bin/sh", {"-c", script}, limits);
    }
    test::TemporaryFolder folder;
};

TEST_F(ProgramOutputs, HoldBothStreamsAndTheExitCode)
{
    const ProgramOutput made = shell("echo out; echo err >&2; exit 3");
    EXPECT_EQ(made.output, "out\n");
    EXPECT_EQ(made.errors, "err\n");
    EXPECT_EQ(made.end, End::exited);
    EXPECT_EQ(made.code, 3);
    EXPECT_FALSE(made.is_good());
    EXPECT_TRUE(shell("cat").is_good()) << "standard input is empty";
    EXPECT_EQ(shell("kill -11 $$").code, 11);
    EXPECT_EQ(shell("kill -11 $$").end, End::killed);
}

TEST_F(ProgramOutputs, PassArgumentsAsTheyAre)
{
    EXPECT_EQ(output_of("/bin/echo", {"$HOME; `ls` \"x\""}).output, "$HOME; `ls` \"x\"\n");
}

TEST_F(ProgramOutputs, EndAtTheirLimits)
{
    EXPECT_EQ(shell("head -c 1000 /dev/zero", {.bytes = 1000}).end, End::exited);
    EXPECT_EQ(shell("head -c 1001 /dev/zero", {.bytes = 1000}).end, End::too_much);
    const ProgramOutput much = shell("head -c 1000000 /dev/zero >&2; echo done");
    EXPECT_EQ(much.output, "done\n") << "a full standard error stops nothing";
    EXPECT_LT(much.errors.size(), 100'000u);
    const auto begin = std::chrono::steady_clock::now();
    const ProgramLimits short_time{.time = std::chrono::milliseconds(200)};
    EXPECT_EQ(shell("sleep 100", short_time).end, End::too_long);
    EXPECT_EQ(shell("sleep 100 & wait", short_time).end, End::too_long) << "a child holds the pipe";
    EXPECT_EQ(shell("exec >&- 2>&-; sleep 100", short_time).end, End::too_long) << "it has closed its pipes";
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));
}

TEST_F(ProgramOutputs, ProgramsAreFoundInAbsoluteFoldersOnly)
{
    const std::string before = std::getenv("PATH") ? std::getenv("PATH") : "";
    const auto path = folder.write("tool", "#!/bin/sh\n");
    ::setenv("PATH", folder.path().c_str(), 1);
    EXPECT_TRUE(find_program("tool").empty()) << "it may not be run";
    std::filesystem::permissions(path, std::filesystem::perms::owner_all);
    EXPECT_EQ(find_program("tool"), path);
    EXPECT_TRUE(find_program("other").empty());
    ::setenv("PATH", ("::.:/none:" + folder.path().string()).c_str(), 1);
    EXPECT_EQ(find_program("tool"), path);
    ::setenv("PATH", ".", 1);
    EXPECT_TRUE(find_program("tool").empty());
    ::setenv("PATH", before.c_str(), 1);
    EXPECT_THROW(output_of(folder / "none", {}), Error);
}

} // namespace
} // namespace oncollide::program_output_test
