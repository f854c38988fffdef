#include "tools/command_fixture.hpp"
#include "tools/csv_rows.hpp"

namespace oncollide::test {
namespace {

TEST_F(CommandLine, BenchContactsComparesScenesAtTheSamePoses)
{
    const Outcome outcome = run({"bench", "contacts", "--scene", "stack-12,stack-1200,enclosed-mesh,knots-1500",
                                 "--steps", "60", "--repeats", "1", "--csv", "c.csv", "--json", "c.json"});
    EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
    EXPECT_NE(folder_.read("c.json").find("\"schema\": \"oncollide.bench_contacts\""), std::string::npos);
    int ours = 0, others = 0;
    for (auto& row : read_csv(folder_.read("c.csv"))) {
        if (row["who"] != "oncollide") {
            ++others;
            if (row["scene"] == "enclosed-mesh") {
                EXPECT_EQ(std::stod(row["contacts"]), 0) << row["who"] << " sees no body inside another";
            } else {
                EXPECT_GT(std::stod(row["contacts"]), 0) << row["who"] << " " << row["scene"];
            }
            continue;
        }
        ++ours;
        EXPECT_EQ(row["complete"], "1") << row["scene"];
        const double contacts = std::stod(row["contacts"]);
        if (row["scene"].starts_with("stack")) {
            EXPECT_EQ(contacts, 20) << "five pairs of four points";
        } else if (row["scene"] == "enclosed-mesh") {
            EXPECT_EQ(contacts, 1);
        } else {
            EXPECT_LE(std::stoi(row["most_points"]), 64);
        }
    }
    EXPECT_EQ(ours, 4);
    EXPECT_GE(others, 4) << "FCL is always there";
    expect_error(64, {"bench", "contacts", "--scene", "none"}, {"--scene", "'none'", "stack-12"});
    expect_error(64, {"bench", "contacts", "--nut", "nut.obj"}, {"--nut and --bolt"});
    expect_error(64, {"bench", "contacts", "--repeats", "0"}, {"--repeats 0"});
}

TEST_F(CommandLine, AccuracyManifoldsContradictsNoClaim)
{
    const Outcome outcome = run({"manifolds", "--pairs", "200", "--seed", "77"});
    EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
    EXPECT_NE(outcome.out.find("0 faults"), std::string::npos) << outcome.out;
    expect_error(64, {"manifolds", "--pairs", "0"}, {"--pairs 0"});
}

} // namespace
} // namespace oncollide::test
