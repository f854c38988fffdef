#include "tools/command_fixture.hpp"

#include "tools/csv_rows.hpp"

namespace oncollide::test {
namespace {

TEST_F(CommandLine, BenchReadRefusesWhatMakesNoSense)
{
    expect_error(64, {"bench", "read", "--triangles", "1"}, {"--triangles 1", "from 2 to"});
    expect_error(64, {"bench", "read", "--repeats", "0"}, {"--repeats 0"});
    expect_error(64, {"bench", "read", "--styles", "obj,fbx"}, {"unknown style 'fbx'", "obj-full", "stl-text"});
    expect_error(73, {"bench", "read", "--csv", "no/where.csv"}, {"no/where.csv"});
    expect_error(64, {"bench", "read", "cube.obj", "--csv", "cube.obj"}, {"--csv cube.obj", "overwrite"});
}

TEST_F(CommandLine, BenchReadReadsEveryStyleAndLeavesNoFile)
{
    const Outcome outcome =
        run({"bench", "read", "--triangles", "5000", "--repeats", "1", "--folder", ".", "--csv", "r.csv"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");
    EXPECT_EQ(folder_.list(), std::vector<std::string>{"r.csv"});
    const auto rows = read_csv(folder_.read("r.csv"));
    EXPECT_EQ(rows.size(), 10u);
    for (auto row : rows) {
        SCOPED_TRACE(row["style"]);
        EXPECT_EQ(row["triangles"], "5000");
        EXPECT_GT(std::stod(row["triangles_per_s"]), 0);
        EXPECT_GT(std::stod(row["bytes"]), 5000 * 12);
    }
    write_cube("cube.off");
    const Outcome own = run({"bench", "read", "cube.off", "--csv", "own.csv"});
    EXPECT_EQ(own.code, 0) << own.err;
    EXPECT_EQ(read_csv(folder_.read("own.csv")).at(0)["triangles"], "12");
    EXPECT_EQ(run({"bench", "read", "missing.obj"}).code, 66);
}

} // namespace
} // namespace oncollide::test
