#include "tools/command_fixture.hpp"
#include "tools/csv_rows.hpp"

namespace oncollide::test {
namespace {

TEST_F(CommandLine, BenchBroadRefusesWhatDoesNotExistBeforeItStarts)
{
    expect_error(64, {"bench", "broad", "--scene", "bron"}, {"unknown scene 'bron'", "brown", "clustered", ".aabbs"});
    expect_error(64, {"bench", "broad", "--scene", "brown,"}, {"unknown scene ''"});
    expect_error(64, {"bench", "broad", "--only", "kd,fcl"}, {"--only fcl", "fcl-tree", "grid"});
    for (const char* bad : {"0", "3M", "10kk", "-1", "k", "1k,", "99999999999999999999"})
        expect_error(64, {"bench", "broad", "--sizes", bad}, {"--sizes", "1 to 2000000"});
    expect_error(64, {"bench", "broad", "--threads", "0"}, {"--threads", "1 to 256"});
    expect_error(64, {"bench", "broad", "--frames", "1"}, {"--frames 1", "2 to"});
    expect_error(66, {"bench", "broad", "--scene", "none.aabbs"}, {"none.aabbs"});
    expect_error(73, {"bench", "broad", "--csv", "no/where.csv"}, {"no/where.csv"});
    expect_error(73, {"bench", "broad", "--plot", "no/where.svg"}, {"no/where.svg"});
    expect_error(64, {"bench", "broad", "--csv", "x", "--plot", "x"}, {"both go to 'x'"});
}

TEST_F(CommandLine, BenchBroadComparesEverybodyOnTheSameBoxes)
{
    const Outcome outcome = run({"bench", "broad", "--scene", "brown,static", "--sizes", "200,1k", "--frames", "60",
                                 "--threads", "1,2", "--csv", "b.csv", "--plot", "b.svg"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("938 pairs, hash 2c42a71ad89f921f: matches the published result"), std::string::npos)
        << outcome.out;
    EXPECT_EQ(outcome.out.find("MISSED"), std::string::npos) << outcome.out;
    const std::string csv = folder_.read("b.csv"), svg = folder_.read("b.svg");
    for (const char* name : {"kd", "octree", "dynamic", "fcl-tree", "grid", "brute"})
        EXPECT_NE(csv.find(fmt::format("12345,{},", name)), std::string::npos) << name;
    for (const auto& row : read_csv(csv)) // a tenth of 'static' moves, all bodies of 'brown' do
        EXPECT_EQ(row.at("regions").find('/') != std::string::npos,
                  row.at("contender") == "dynamic" && row.at("scene") == "static")
            << row.at("contender") << row.at("scene") << row.at("boxes");
    EXPECT_TRUE(svg.starts_with("<svg") && svg.ends_with("</svg>\n"));
    EXPECT_NE(svg.find("kd, 2 threads"), std::string::npos);
    EXPECT_NE(svg.find("ms per frame"), std::string::npos);

    const Outcome growth = run({"bench", "broad", "--scene", "giant,jump", "--sizes", "300,900", "--frames", "6",
                                "--only", "kd,octree,dynamic,grid", "--plot", "g.svg", "--per-box"});
    EXPECT_EQ(growth.code, 0) << growth.err;
    EXPECT_NE(folder_.read("g.svg").find("ns per box"), std::string::npos);
    expect_error(64, {"bench", "broad", "--per-box"}, {"--plot"});
}

} // namespace
} // namespace oncollide::test
