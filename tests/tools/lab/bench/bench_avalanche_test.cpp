#include <algorithm>

#include "tools/command_fixture.hpp"
#include "tools/csv_rows.hpp"

namespace oncollide::test {
namespace {

TEST_F(CommandLine, BenchAvalancheComesToRestAboveTheHill)
{
    const Outcome outcome = run({"bench", "avalanche", "--bodies", "30", "--meshes", "2", "--csv", "a.csv"});
    EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
    const auto rows = read_csv(folder_.read("a.csv"));
    double most_contacts = 0;
    bool rests = false;
    for (auto row : rows) {
        if (!row["who"].starts_with("oncollide")) continue;
        EXPECT_EQ(row["lost"], "0") << row["s"];
        most_contacts = std::max(most_contacts, std::stod(row["contacts"]));
        if (row["who"] != "oncollide, at rest") continue;
        rests = true;
        EXPECT_EQ(row["awake"], "0");
    }
    EXPECT_TRUE(rests);
    EXPECT_GE(most_contacts, 32) << "each body lies on something";
    EXPECT_GT(std::stod(rows.front().at("awake")), 20) << "they fall at first";
}

TEST_F(CommandLine, BenchAvalancheReportsBodiesThatStillMove)
{
    EXPECT_EQ(run({"bench", "avalanche", "--bodies", "10", "--seconds", "1", "--only", "oncollide"}).code, 70);
}

} // namespace
} // namespace oncollide::test
