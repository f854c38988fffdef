#include "tools/command_fixture.hpp"
#include "tools/csv_rows.hpp"

#include <cmath>
#include <random>
#include <sstream>

#include "narrowphase/mesh_parts.hpp"
#include "trees/level_quality.hpp"
#include <oncollide/samples/generators.hpp>

namespace oncollide::test {
namespace {

using Eigen::Vector3d;
using tools::CoveringVolume;
using tools::judge_level;
using tools::SurfaceIndex;

// The judge

TEST(SurfaceIndex, FindsTheNearestPointAndTheInsideOfAKnot)
{
    const Mesh mesh = make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 600);
    const SurfaceIndex index(mesh);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(-1.8, 1.8);
    int inside = 0;
    for (int i = 0; i < 2000; ++i) {
        const Vector3d p(uniform(random), uniform(random), uniform(random) / 2);
        double least = 1e300;
        for (const Triangle& t : mesh.triangles)
            least = std::min(
                least,
                (tools::nearest_point(p, mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]) - p).norm());
        EXPECT_DOUBLE_EQ(index.nearest(p).distance, least);
        EXPECT_LT(index.nearest(p, 2 * least).distance, 2 * least);
        EXPECT_EQ(index.inside(p), winding_number(mesh, p) > 0.5) << p.transpose();
        inside += index.inside(p);
    }
    EXPECT_GT(inside, 30);
}

TEST(SurfaceIndex, NearestPointsOfTrianglesOfAnyShape)
{
    const Vector3d a(0, 0, 0), b(2, 0, 0), c(0, 2, 0);
    EXPECT_EQ(tools::nearest_point({0.5, 0.5, 3}, a, b, c), Vector3d(0.5, 0.5, 0));
    EXPECT_EQ(tools::nearest_point({2, 2, 1}, a, b, c), Vector3d(1, 1, 0));
    EXPECT_EQ(tools::nearest_point({-1, -1, 1}, a, b, c), a);
    EXPECT_EQ(tools::nearest_point({1, 5, 0}, a, b, b), Vector3d(1, 0, 0)) << "a segment";
    EXPECT_EQ(tools::nearest_point({1, 5, 0}, b, b, b), b) << "a point";
}

/// A square of side 2 in the plane z = 0.
Mesh square()
{
    return make_mesh("square", {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}, {{0, 1, 2}, {0, 2, 3}});
}

CoveringVolume ball(const Vector3d& centre, double radius)
{
    return CoveringVolume::of_ball(centre, radius);
}

TEST(LevelQuality, OverReachIsTheDistanceOfTheFarthestPoint)
{
    const Mesh mesh = square();
    const SurfaceIndex index(mesh);
    const std::vector<CoveringVolume> both{ball({0, 0, 0.25}, 0.5), ball({2, 0, 0}, 0.5)};
    const auto quality = judge_level(mesh, index, both);
    EXPECT_NEAR(quality.reaches.at(0).either, 0.75, 1e-12);
    EXPECT_NEAR(quality.reaches.at(1).either, 1.5, 1e-12);
    EXPECT_NEAR(quality.worst.either, 1.5, 1e-12);
    EXPECT_NEAR(quality.mean.either, (0.75 + 1.5) / 2, 1e-12);
    EXPECT_NEAR(quality.volume, 2 * 4 / 3.0 * M_PI * 0.125, 1e-12);
}

TEST(LevelQuality, TheFarthestPointOfABoxIsACorner)
{
    const Mesh mesh = square();
    const SurfaceIndex index(mesh);
    // Rotated by 45 degrees about x and moved up: an edge points up, by sqrt(2) / 4.
    const CoveringVolume box{.centre = {0, 0, 0.25},
                             .half = {0.5, 0.25, 0.25},
                             .axes = Eigen::AngleAxisd(M_PI / 4, Vector3d::UnitX()).toRotationMatrix()};
    const auto quality = judge_level(mesh, index, {&box, 1}, {.directions = 1});
    EXPECT_NEAR(quality.worst.either, 0.25 + std::sqrt(2) / 4, 1e-12);
    EXPECT_NEAR(quality.volume, 0.25, 1e-12);
    EXPECT_NEAR(box.radius(), std::sqrt(0.375), 1e-12);
    EXPECT_TRUE(box.holds({0.5, 0, 0.25 + std::sqrt(2) / 4}, 1e-12)) << "a corner";
    EXPECT_FALSE(box.holds({0.5, 0, 0.26 + std::sqrt(2) / 4}, 1e-12));
    EXPECT_FALSE(box.holds({0.51, 0, 0.25}, 1e-12));
    EXPECT_FALSE(box.holds({0, 0.25, 0.45}, 1e-12)) << "in the axis-aligned box, not in the rotated box";
    const CoveringVolume aside{.centre = {3, 3, 0}, .half = {0.5, 0.25, 0.125}};
    EXPECT_NEAR(judge_level(mesh, index, {&aside, 1}, {.directions = 1}).worst.either,
                Vector3d(2.5, 2.25, 0.125).norm(), 1e-12);
    const CoveringVolume flat{.centre = {2, 0, 0}, .half = {0.5, 0, 0}};
    EXPECT_NEAR(judge_level(mesh, index, {&flat, 1}).worst.either, 1.5, 1e-12);
}

TEST(LevelQuality, BeyondCountsThePointsOutsideABodyAlone)
{
    const Mesh mesh = make_box_mesh({10, 10, 10});
    const SurfaceIndex index(mesh);
    const CoveringVolume sphere = ball({9.75, 0, 0}, 1);
    const auto quality = judge_level(mesh, index, {&sphere, 1}, {.closed = true});
    EXPECT_NEAR(quality.worst.either, 1.25, 1e-12);
    EXPECT_NEAR(quality.worst.beyond, 0.75, 1e-12);
}

TEST(LevelQuality, CoverageFindsWhatIsLeftOut)
{
    const Mesh mesh = square();
    const SurfaceIndex index(mesh);
    std::vector<CoveringVolume> volumes{ball({0, 0, 0}, std::sqrt(2.0))};
    EXPECT_EQ(judge_level(mesh, index, volumes).open_triangles, 0u) << "it passes through the corners";
    volumes = {ball({0, 0, 0}, std::sqrt(2.0) - 1e-6)};
    EXPECT_EQ(judge_level(mesh, index, volumes).open_triangles, 2u) << "the corners are outside by a millionth";
    EXPECT_EQ(judge_level(mesh, index, volumes).outside, 6u) << "three of each triangle; no other point is as near";
    volumes = {ball({0, 0, 0}, 1)};
    const auto round = judge_level(mesh, index, volumes);
    EXPECT_NEAR(round.uncovered, 4 - M_PI, 0.15);
    EXPECT_NEAR(double(round.outside) / double(round.points), (4 - M_PI) / 4, 0.01);
    // Four volumes around the quarters cover all of it, and meet only at the centre: as spheres, and as flat boxes.
    for (const bool boxes : {false, true}) {
        SCOPED_TRACE(boxes);
        for (const double less : {0.0, 1e-9}) {
            volumes.clear();
            for (const double x : {-0.5, 0.5})
                for (const double y : {-0.5, 0.5})
                    volumes.push_back(boxes ? CoveringVolume{.centre = {x, y, 0}, .half = {0.5 - less, 0.5 - less, 0}}
                                            : ball({x, y, 0}, std::sqrt(0.5) - less));
            EXPECT_EQ(judge_level(mesh, index, volumes).open_triangles, less > 0 ? 2u : 0u);
        }
    }
    // A box with the square in one of its faces, and a box that ends below the square.
    volumes = {{.centre = {0, 0, 0.1}, .half = {1, 1, 0.1}}};
    EXPECT_EQ(judge_level(mesh, index, volumes).open_triangles, 0u);
    volumes[0].half.z() = 0.0999;
    EXPECT_NEAR(judge_level(mesh, index, volumes).uncovered, 4, 1e-12);
}

// The command

class Spheres : public CommandLine {
protected:
    void SetUp() override { write_cube("cube.off"); }
};

TEST_F(Spheres, ListsCountsAndCoverageOfEveryLevel)
{
    const Outcome outcome =
        run({"spheres", "cube.off", "--depth", "3", "--json", "-", "--csv", "s.csv", "--levels", "l.csv"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("cube.off: 12 triangles, closed; longest side 1 m"), std::string::npos) << outcome.err;
    const nlohmann::json result = nlohmann::json::parse(outcome.out);
    EXPECT_EQ(result.at("header").at("depth"), 3);
    const std::size_t spheres[] = {1, 8, 56, 296}, boxes[] = {1, 8, 12};
    for (const auto& level : result.at("levels")) {
        const int l = level.at("level");
        const bool sphere = level.at("kind") == "sphere";
        EXPECT_EQ(level.at("count"), sphere ? spheres[l] : boxes[l]);
        EXPECT_EQ(level.at("open_triangles"), 0);
        EXPECT_EQ(level.at("points_outside"), 0);
        if (sphere) {
            EXPECT_NEAR(level.at("certified").get<double>(), std::sqrt(3) * std::ldexp(1.0, -l), 1e-4);
        }
        EXPECT_LE(level.at("over_reach").at("worst"), level.at("certified"));
        EXPECT_GE(level.at("over_reach").at("worst"), level.at("over_reach_outside").at("worst"));
    }
    EXPECT_EQ(result.at("levels").size(), 4 + 3u);
    EXPECT_EQ(result.at("rows").size(), 1 + 8 + 56 + 296u);
    EXPECT_EQ(result.at("columns").at(5), "radius");
    EXPECT_NEAR(result.at("rows").at(0).at(5).get<double>(), std::sqrt(3) / 2, 1e-6) << "the root's radius";

    std::istringstream rows(folder_.read("s.csv"));
    std::string row;
    std::getline(rows, row);
    EXPECT_EQ(row, "level,cell,x,y,z,radius,over_reach,over_reach_outside");
    std::size_t count = 0;
    while (std::getline(rows, row)) ++count;
    EXPECT_EQ(count, result.at("rows").size());

    const auto levels = read_csv(folder_.read("l.csv"));
    ASSERT_EQ(levels.size(), result.at("levels").size());
    for (std::size_t k = 0; k < levels.size(); ++k) {
        const auto& level = result.at("levels").at(k);
        EXPECT_EQ(levels[k].at("kind"), level.at("kind"));
        EXPECT_EQ(std::stoul(levels[k].at("count")), level.at("count"));
        EXPECT_GT(std::stoul(levels[k].at("tree_bytes")), 8 * std::stoul(levels[k].at("triangles")));
        EXPECT_EQ(std::stod(levels[k].at("mean_outside")), level.at("over_reach_outside").at("mean"));
    }
    expect_error(64, {"spheres", "cube.off", "--levels", "x.csv", "--csv", "x.csv"}, {"both go to 'x.csv'"});
}

TEST_F(Spheres, WritesTightOnesAsOrientedBoxes)
{
    ASSERT_EQ(
        run({"spheres", "cube.off", "--depth", "2", "--quiet", "--bounding-volume", "obb", "--json", "s.json"}).code,
        0);
    const nlohmann::json result = read_json("s.json");
    ASSERT_EQ(result.at("columns").size(), 18u);
    ASSERT_EQ(result.at("rows").size(), 1 + 8 + 12u);
    for (const auto& row : result.at("rows")) {
        ASSERT_EQ(row.size(), 18u);
        const std::vector<double> box = row;
        for (const int axis : {7, 10, 13}) EXPECT_NEAR(std::hypot(box[axis], box[axis + 1], box[axis + 2]), 1, 1e-6);
        if (box[0] < 2) continue;
        EXPECT_LT(*std::min_element(&box[4], &box[7]), 1e-4) << "one triangle is flat";
        // The box of half a square is the square.
        EXPECT_NEAR(*std::max_element(&box[4], &box[7]), 0.5, 1e-3);
        EXPECT_NEAR(box[16], 0, 1e-3);
        EXPECT_NEAR(box[17], 0, 1e-3);
    }
}

TEST_F(Spheres, OfAPointAreTheEightCellsThatMeetInIt)
{
    folder_.write("point.obj", "v 1 2 3\nf 1 1 1\n");
    ASSERT_EQ(run({"spheres", "point.obj", "--depth", "2", "--quiet", "--json", "s.json"}).code, 0);
    for (const auto& level : read_json("s.json").at("levels"))
        EXPECT_EQ(level.at("count"), level.at("level") == 0 ? 1 : 8);
}

TEST_F(Spheres, MaxErrorChoosesTheDepth)
{
    const auto depth = [&](const char* max_error) {
        EXPECT_EQ(run({"spheres", "cube.off", "--max-error", max_error, "--quiet", "--json", "s.json"}).code, 0);
        return read_json("s.json").at("header").at("depth").get<int>();
    };
    // Two trees with leaves of radius 0.866 / 2^d certify 4 such radii.
    EXPECT_EQ(depth("1"), 2);
    EXPECT_EQ(depth("0.4"), 4);
}

TEST_F(Spheres, RefusesWhatItCannotDoInOneLine)
{
    folder_.write("bad.off", "OFF\n1 1 0\n0 0 0\n3 0 1 2\n");
    expect_error(66, {"spheres", "missing.off"}, {"missing.off"});
    expect_error(65, {"spheres", "bad.off"}, {"bad.off", "vertex 1"});
    expect_error(64, {"spheres", "cube.off", "--depth", "17"}, {"depth"});
    expect_error(64, {"spheres", "cube.off", "--depth", "3", "--max-error", "0.1"}, {"max-error"});
    expect_error(64, {"spheres", "cube.off", "--bounding-volume", "auto"}, {"sphere or obb"});
    expect_error(64, {"spheres", "cube.off", "--directions", "0"}, {"--directions"});
    expect_error(64, {"spheres", "cube.off", "--csv", "cube.off"}, {"overwrite the input"});
    expect_error(64, {"spheres", "cube.off", "--csv", "a", "--json", "a"}, {"both go to"});
    expect_error(73, {"spheres", "cube.off", "--csv", "no/s.csv"}, {"no/s.csv"});
    expect_error(64, {"spheres", "cube.off", "--depth", "16"}, {"--depth", "at most"});
}

} // namespace
} // namespace oncollide::test
