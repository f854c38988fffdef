// oncollide check --self.
#include "tools/command_fixture.hpp"

namespace oncollide::test {
namespace {

class CheckSelf : public CommandLine {
protected:
    void SetUp() override
    {
        write_cube("cube.off");
        // The second triangle pierces the first; the third and the fourth, elsewhere, are copies.
        folder_.write("crossed.off", "OFF\n9 4 0\n0 0 0\n4 0 0\n0 4 0\n1 1 -1\n1 1 1\n2 1 1\n9 0 0\n9 1 0\n9 0 1\n"
                                     "3 0 1 2\n3 3 4 5\n3 6 7 8\n3 8 7 6\n");
    }
};

TEST_F(CheckSelf, NamesThePlacesWhereAMeshMeetsItself)
{
    const Outcome crossed = run({"check", "crossed.off", "--self"});
    EXPECT_EQ(crossed.code, 1) << crossed.err;
    EXPECT_EQ(crossed.out, "colliding: 'crossed.off' meets itself: 2 pairs of triangles, in 2 places.\n"
                           "  1 pair around (1.25, 1, 0), in a box of 0.5 x 0 x 0 m, such as triangles 0 and 1\n"
                           "  1 pair around (9, 0.5, 0.5), in a box of 0 x 1 x 1 m, such as triangles 2 and 3\n");
    const Outcome cube = run({"check", "cube.off", "--self"});
    EXPECT_EQ(cube.code, 0) << cube.err;
    EXPECT_EQ(cube.out, "separate: 'cube.off' does not meet itself.\n");
    EXPECT_EQ(run({"check", "crossed.off", "--self", "--quiet"}).out, "");
}

TEST_F(CheckSelf, WritesPlacesAsJsonAndPairsAsCsv)
{
    const Outcome outcome = run({"check", "crossed.off", "--self", "--json", "-", "--contacts", "pairs.csv"});
    EXPECT_EQ(outcome.code, 1) << outcome.err;
    const nlohmann::json mesh = nlohmann::json::parse(outcome.out).at("meshes").at(0);
    EXPECT_EQ(mesh.at("file"), "crossed.off");
    EXPECT_EQ(mesh.at("triangles"), 4);
    EXPECT_EQ(mesh.at("pairs"), 2);
    ASSERT_EQ(mesh.at("places").size(), 2u);
    EXPECT_EQ(mesh.at("places").at(0).at("triangles"), nlohmann::json({0, 1}));
    EXPECT_EQ(mesh.at("places").at(0).at("min"), nlohmann::json({1.0, 1.0, 0.0}));
    EXPECT_EQ(mesh.at("places").at(0).at("max"), nlohmann::json({1.5, 1.0, 0.0}));
    const std::string rows = folder_.read("pairs.csv");
    EXPECT_NE(rows.find("\n0,1,crossing,"), std::string::npos) << rows;
    EXPECT_NE(rows.find("\n2,3,touching,"), std::string::npos) << rows;
}

TEST_F(CheckSelf, ChecksEachMeshOfAFolder)
{
    std::filesystem::create_directory(folder_ / "parts");
    for (const char* name : {"cube.off", "crossed.off"})
        std::filesystem::copy_file(folder_ / name, folder_ / "parts" / name);
    const Outcome outcome = run({"check", "parts", "--self"});
    EXPECT_EQ(outcome.code, 1) << outcome.err;
    EXPECT_TRUE(outcome.out.ends_with("1 of 2 meshes meet themselves.\n")) << outcome.out;
    expect_error(64, {"check", "parts", "--self", "--contacts", "pairs.csv"}, {"--contacts", "one mesh"});
}

TEST_F(CheckSelf, RefusesASecondBodyAndPoses)
{
    expect_error(64, {"check", "cube.off"}, {"B", "--self"});
    expect_error(64, {"check", "cube.off", "cube.off", "--self"}, {"--self"});
    expect_error(64, {"check", "cube.off", "--self", "--pose-a", "0 0 0 0 0 0 1"}, {"--self"});
    expect_error(64, {"check", "cube.off", "--self", "--distance", "0"}, {"--self"});
    expect_error(66, {"check", "absent.off", "--self"}, {"absent.off"});
    expect_error(64, {"check", "crossed.off", "--self", "--json", "crossed.off"}, {"crossed.off"});
}

} // namespace
} // namespace oncollide::test
