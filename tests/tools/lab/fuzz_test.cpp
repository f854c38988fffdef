#include "tools/command_fixture.hpp"

namespace oncollide::test {
namespace {

TEST_F(CommandLine, TheFuzzerTakesSweeps)
{
    expect_error(64, {"fuzz", "--csv", "x.csv"}, {"--sweeps"});
    const Outcome outcome = run({"fuzz", "--scenes", "0", "--sweeps", "300", "--seed", "9", "--csv", "f.csv"});
    EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
    EXPECT_NE(outcome.out.find("300 sweeps, seeds 9 to 308: "), std::string::npos) << outcome.out;
    EXPECT_NE(outcome.out.find(": 0 missed, 0 early, 0 out of tolerance, 0 changed"), std::string::npos) << outcome.out;
    const std::string csv = folder_.read("f.csv");
    EXPECT_TRUE(csv.starts_with("a,b,sweeps,contacts,at_start,clear,open,poses,truths,missed,early,wide,changed\n"))
        << csv;
    EXPECT_NE(csv.find("\nall,all,300,"), std::string::npos) << csv;
}

} // namespace
} // namespace oncollide::test
