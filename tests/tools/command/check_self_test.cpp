// oncollide check --self.
#include "tools/decoded_png.hpp"
#include "tools/view_fixture.hpp"

namespace oncollide::test {
namespace {

class CheckSelf : public View {
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

TEST_F(CheckSelf, PrintsPositionsWithoutRoundingErrors)
{
    folder_.write("near.off", "OFF\n6 2 0\n0 0 1e-12\n4 0 1e-12\n0 4 1e-12\n1 1 -1\n1 1 1\n2 1 1\n3 0 1 2\n3 3 4 5\n");
    EXPECT_NE(run({"check", "near.off", "--self"}).out.find("around (1.25, 1, 0), in a box of 0.5 x 0 x 0 m"),
              std::string::npos);
}

TEST_F(CheckSelf, TakesVerticesAtOnePositionForOneVertexOfAPlace)
{
    // Two strips of two triangles with own vertices cross along one line.
    folder_.write("strips.off", "OFF\n12 4 0\n0 0 0\n4 0 0\n4 4 0\n0 0 0\n4 4 0\n0 4 0\n"
                                "1 2 -1\n3 1 -1\n3 1 1\n1 2 -1\n3 1 1\n1 2 1\n3 0 1 2\n3 3 4 5\n3 6 7 8\n3 9 10 11\n");
    EXPECT_NE(run({"check", "strips.off", "--self"}).out.find("in 1 place."), std::string::npos);
}

TEST_F(CheckSelf, DrawsTheTrianglesThatMeetInRed)
{
    const auto is_red = [](const std::uint8_t* pixel) { return pixel[0] > 2 * pixel[1]; };
    const auto is_pale = [](const std::uint8_t* pixel) { return pixel[2] > pixel[0]; };
    EXPECT_EQ(run({"check", "cube.off", "--self", "--picture", "cube.png"}).code, 0);
    const Decoded cube = decode(folder_.read("cube.png"));
    EXPECT_EQ(cube.width, 480);
    EXPECT_EQ(cube.count(is_red), 0);
    EXPECT_GT(cube.count(is_pale), 5000);
    EXPECT_EQ(run({"check", "crossed.off", "--self", "--picture", "crossed.png"}).code, 1);
    const Decoded crossed = decode(folder_.read("crossed.png"));
    EXPECT_EQ(crossed.width, 960);
    EXPECT_GT(crossed.count(is_red, 0, 480), 1000);
    EXPECT_GT(crossed.count(is_red, 480, 960), 5000);
    EXPECT_EQ(crossed.count(is_pale), 0) << "all triangles meet another one";
    expect_error(64, {"check", "cube.off", "--self", "--picture", "cube.jpg"}, {"--picture", ".png"});
    expect_error(64, {"check", "cube.off", "cube.off", "--picture", "cube.png"}, {"--self"});
}

TEST_F(CheckSelf, DrawsTrianglesThatTheMeshHidesInTheCloseUp)
{
    // Two triangles that cross inside a closed cube.
    folder_.write("hidden.off",
                  "OFF\n14 14 0\n0 0 0\n9 0 0\n0 9 0\n9 9 0\n0 0 9\n9 0 9\n0 9 9\n9 9 9\n4 4 4\n5 4 4\n4 5 4\n4 4 3.5\n"
                  "4 4 4.5\n5 5 4.5\n3 0 2 1\n3 1 2 3\n3 4 5 6\n3 5 7 6\n3 0 1 4\n3 1 5 4\n3 2 6 3\n3 3 6 7\n"
                  "3 0 4 2\n3 2 4 6\n3 1 3 5\n3 3 7 5\n3 8 9 10\n3 11 12 13\n");
    EXPECT_EQ(run({"check", "hidden.off", "--self", "--picture", "hidden.png"}).code, 1);
    const Decoded image = decode(folder_.read("hidden.png"));
    const auto is_red = [](const std::uint8_t* pixel) { return pixel[0] > 2 * pixel[1]; };
    EXPECT_EQ(image.count(is_red, 0, 480), 0);
    EXPECT_GT(image.count(is_red, 480, 960), 2000);
}

TEST_F(CheckSelf, WritesAPageWhoseCollidingPairsAreThePlaces)
{
    const Outcome outcome = run_without_three({"check", "crossed.off", "--self", "--view", "x.html"});
    EXPECT_EQ(outcome.code, 1) << outcome.err;
    const nlohmann::json page = header();
    EXPECT_EQ(page.at("names"),
              nlohmann::json({"place 1, one side", "place 1, other side", "place 2, one side", "place 2, other side"}));
    EXPECT_EQ(page.at("frames").at(0).at("verdicts"), nlohmann::json({0, 0, 2, 0}));
    const Outcome cube = run_without_three({"check", "cube.off", "--self", "--view", "cube.html"});
    EXPECT_EQ(cube.code, 0) << cube.err;
    EXPECT_EQ(header("cube.html").at("names"), nlohmann::json({"mesh"}));
    EXPECT_EQ(header("cube.html").at("frames").at(0).at("pairs"), 0);
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
