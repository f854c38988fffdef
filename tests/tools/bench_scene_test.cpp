#include "command_fixture.hpp"

namespace oncollide::test {
namespace {

TEST_F(CommandLine, BenchManyFindsTheContactsThatFclFinds)
{
    expect_error(64, {"bench", "many", "--contacts"}, {"--contacts", "--exact predicates"});
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
    EXPECT_NE(outcome.out.find("bytes a triangle"), std::string::npos);
}

} // namespace
} // namespace oncollide::test
