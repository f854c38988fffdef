#include "command_fixture.hpp"

#include <cmath>
#include <random>
#include <sstream>

#include "sphere_quality.hpp"
#include <oncollide/narrowphase/solid.hpp>
#include <oncollide/scenes/mesh_generators.hpp>

namespace oncollide::test {
namespace {

using Eigen::Vector3d;
using tools::judge_spheres;
using tools::TriangleTree;

// The judge

TEST(TriangleTree, FindsTheNearestPointAndTheInsideOfAKnot)
{
    const Mesh mesh = make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 600);
    const TriangleTree tree(mesh);
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
        EXPECT_DOUBLE_EQ(tree.nearest(p).distance, least);
        EXPECT_LT(tree.nearest(p, 2 * least).distance, 2 * least);
        EXPECT_EQ(tree.inside(p), winding_number(mesh, p) > 0.5) << p.transpose();
        inside += tree.inside(p);
    }
    EXPECT_GT(inside, 30);
}

TEST(TriangleTree, NearestPointsOfTrianglesOfAnyShape)
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

TEST(SphereQuality, OverReachIsTheDistanceOfTheFarthestPoint)
{
    const Mesh mesh = square();
    const TriangleTree tree(mesh);
    const TreeSphere above{{0, 0, 0.25}, 0.5}, aside{{2, 0, 0}, 0.5};
    const TreeSphere disc{{0, 0, 0.25}, 0.5, Vector3d::UnitZ(), 0.125};
    EXPECT_NEAR(judge_spheres(mesh, tree, {&above, 1}).worst, 0.75, 1e-12);
    EXPECT_NEAR(judge_spheres(mesh, tree, {&aside, 1}).worst, 1.5, 1e-12);
    EXPECT_NEAR(judge_spheres(mesh, tree, {&disc, 1}).worst, 0.375, 1e-12);
    const std::vector<TreeSphere> both{above, aside};
    EXPECT_NEAR(judge_spheres(mesh, tree, both).mean, (0.75 + 1.5) / 2, 1e-12);
    EXPECT_NEAR(judge_spheres(mesh, tree, {&above, 1}).volume, 4 / 3.0 * M_PI * 0.125, 1e-12);
    EXPECT_NEAR(judge_spheres(mesh, tree, {&disc, 1}).volume, 2 * M_PI * (0.25 * 0.125 - 0.125 * 0.125 * 0.125 / 3),
                1e-12);
}

TEST(SphereQuality, BeyondCountsThePointsOutsideABodyAlone)
{
    const Mesh mesh = make_box_mesh({10, 10, 10});
    const TriangleTree tree(mesh);
    const TreeSphere sphere{{9.75, 0, 0}, 1};
    const auto quality = judge_spheres(mesh, tree, {&sphere, 1}, {.closed = true});
    EXPECT_NEAR(quality.worst, 1.25, 1e-12);
    EXPECT_NEAR(quality.worst_beyond, 0.75, 1e-12);
}

TEST(SphereQuality, CoverageFindsWhatIsLeftOut)
{
    const Mesh mesh = square();
    const TriangleTree tree(mesh);
    std::vector<TreeSphere> spheres{{{0, 0, 0}, std::sqrt(2.0)}};
    EXPECT_EQ(judge_spheres(mesh, tree, spheres).open_triangles, 0u) << "it passes through the corners";
    spheres[0].radius = std::sqrt(2.0) - 1e-6;
    EXPECT_EQ(judge_spheres(mesh, tree, spheres).open_triangles, 2u) << "the corners are out by a millionth";
    EXPECT_EQ(judge_spheres(mesh, tree, spheres).outside, 6u) << "three of each triangle; no other point comes so near";
    spheres[0].radius = 1;
    const auto round = judge_spheres(mesh, tree, spheres);
    EXPECT_NEAR(round.uncovered, 4 - M_PI, 0.15);
    EXPECT_NEAR(double(round.outside) / double(round.points), (4 - M_PI) / 4, 0.01);
    // Four spheres around the quarters leave nothing out, and meet in the middle alone.
    spheres.clear();
    for (const double x : {-0.5, 0.5})
        for (const double y : {-0.5, 0.5}) spheres.push_back({{x, y, 0}, std::sqrt(0.5)});
    EXPECT_EQ(judge_spheres(mesh, tree, spheres).open_triangles, 0u);
    for (TreeSphere& s : spheres) s.radius -= 1e-9;
    EXPECT_EQ(judge_spheres(mesh, tree, spheres).open_triangles, 2u);
    // Slabs that the square lies beside.
    for (TreeSphere& s : spheres) s = {s.centre + Vector3d(0, 0, 0.1), 2, Vector3d::UnitZ(), 0.1};
    EXPECT_EQ(judge_spheres(mesh, tree, spheres).open_triangles, 0u);
    for (TreeSphere& s : spheres) s.half = 0.0999;
    EXPECT_NEAR(judge_spheres(mesh, tree, spheres).uncovered, 4, 1e-12);
}

// The command

class Spheres : public CommandLine {
protected:
    void SetUp() override { write_cube("cube.off"); }
};

TEST_F(Spheres, ListsCountsAndCoverageOfEveryLevel)
{
    const Outcome outcome = run({"spheres", "cube.off", "--depth", "3", "--json", "-", "--csv", "s.csv"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("cube.off: 12 triangles, closed; longest side 1 m"), std::string::npos) << outcome.err;
    const nlohmann::json result = nlohmann::json::parse(outcome.out);
    EXPECT_EQ(result.at("header").at("depth"), 3);
    const std::size_t counts[] = {1, 8, 56, 296};
    std::size_t all = 0;
    for (const auto& level : result.at("levels")) {
        const int l = level.at("level");
        EXPECT_EQ(level.at("spheres"), counts[l]);
        EXPECT_EQ(level.at("open_triangles"), 0);
        EXPECT_EQ(level.at("points_outside"), 0);
        EXPECT_NEAR(level.at("certified").get<double>(), std::sqrt(3) * std::ldexp(1.0, -l), 1e-4);
        EXPECT_LE(level.at("over_reach").at("worst"), level.at("certified"));
        EXPECT_GE(level.at("over_reach").at("worst"), level.at("over_reach_outside").at("worst"));
        if (level.at("kind") == "plain") all += counts[l];
    }
    EXPECT_EQ(result.at("levels").size(), 1 + 3 * 3u);
    EXPECT_EQ(result.at("spheres").size(), all);
    EXPECT_NEAR(result.at("spheres").at(0).at(4).get<double>(), std::sqrt(3) / 2, 1e-6) << "the root's radius";

    std::istringstream rows(folder_.read("s.csv"));
    std::string row;
    std::getline(rows, row);
    EXPECT_EQ(row, "level,cell,x,y,z,radius,normal_x,normal_y,normal_z,half_thickness");
    std::size_t count = 0;
    while (std::getline(rows, row)) ++count;
    EXPECT_EQ(count, all);
}

TEST_F(Spheres, WritesTightOnesWithTheirSlabs)
{
    ASSERT_EQ(run({"spheres", "cube.off", "--depth", "2", "--quiet", "--spheres", "tight", "--json", "s.json"}).code,
              0);
    const nlohmann::json result = read_json("s.json");
    const double root = result.at("spheres").at(0).at(4);
    int thin = 0;
    for (const auto& s : result.at("spheres")) {
        EXPECT_LE(s.at(4).get<double>(), root * std::ldexp(1.0, -s.at(0).get<int>()) * (1 + 1e-12));
        EXPECT_NEAR(std::hypot(s.at(5).get<double>(), s.at(6).get<double>(), s.at(7).get<double>()), 1, 1e-12);
        thin += s.at(8).get<double>() < 0.1 * s.at(4).get<double>();
    }
    EXPECT_EQ(thin, 24) << "the four cells in the middle of each side hold a square";
}

TEST_F(Spheres, OfAPointAreTheEightCellsThatMeetInIt)
{
    folder_.write("point.obj", "v 1 2 3\nf 1 1 1\n");
    ASSERT_EQ(run({"spheres", "point.obj", "--depth", "2", "--quiet", "--json", "s.json"}).code, 0);
    for (const auto& level : read_json("s.json").at("levels"))
        EXPECT_EQ(level.at("spheres"), level.at("level") == 0 ? 1 : 8);
}

TEST_F(Spheres, MaxErrorChoosesTheDepth)
{
    const auto depth = [&](const char* max_error) {
        EXPECT_EQ(run({"spheres", "cube.off", "--max-error", max_error, "--quiet", "--json", "s.json"}).code, 0);
        return read_json("s.json").at("header").at("depth").get<int>();
    };
    // Two trees of leaves of radius 0.866 / 2^d certify 4 of them.
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
    expect_error(64, {"spheres", "cube.off", "--spheres", "auto"}, {"paper or tight"});
    expect_error(64, {"spheres", "cube.off", "--directions", "0"}, {"--directions"});
    expect_error(64, {"spheres", "cube.off", "--csv", "cube.off"}, {"overwrite the input"});
    expect_error(64, {"spheres", "cube.off", "--csv", "a", "--json", "a"}, {"both go to"});
    expect_error(73, {"spheres", "cube.off", "--csv", "no/s.csv"}, {"no/s.csv"});
    expect_error(64, {"spheres", "cube.off", "--depth", "16"}, {"--depth", "at most"});
}

} // namespace
} // namespace oncollide::test
