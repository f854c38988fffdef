// The quadtree of a terrain: its boxes, its roots, and its traversals, compared with brute force.
#include <algorithm>
#include <functional>

#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/walks/traversal.hpp>
#include <oncollide/samples/generators.hpp>

#include "random_pose.hpp"

namespace oncollide {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

Terrain random_terrain(std::uint32_t columns, std::uint32_t rows, double holes, std::uint64_t seed)
{
    TerrainGrid grid{.columns = columns, .rows = rows};
    grid.spacing = {0.1, 0.2}, grid.origin = {1000, -2000, 5}, grid.no_data = -1;
    std::vector<double> heights;
    for (std::uint64_t i = 0; i < std::uint64_t(columns) * rows; ++i)
        heights.push_back(u01(seed, i, 1) < holes ? -1 : u01(seed, i, 0));
    return make_terrain("random", grid, heights);
}

struct Size {
    std::uint32_t columns, rows;
};

TEST(TerrainTree, BoxesHoldTheirTrianglesAndEveryTriangleIsInOneLeaf)
{
    for (const auto& [columns, rows] : {Size{2, 2}, Size{2, 40}, Size{700, 2}, Size{9, 9}, Size{10, 18}, Size{130, 67}})
        for (const double holes : {0.0, 0.2}) {
            const Terrain terrain = random_terrain(columns, rows, columns * rows < 5 ? 0 : holes, columns + rows);
            const TerrainTree tree(terrain);
            std::vector<int> seen(2 * std::size_t(terrain.cells_x()) * terrain.cells_y());
            std::vector<Aabb> around; // the boxes on the path from the root
            const double slack = 50 * 0x1p-24 * tree.radius();
            std::function<void(const TerrainTree::Node&)> down = [&](const TerrainTree::Node& node) {
                OpenBoxes boxes;
                const LaneMasks masks = tree.open(node, nullptr, boxes);
                for (unsigned k = 0; k < 8; ++k) {
                    if (boxes.c[0][k] > 1e29f) continue;
                    Aabb box;
                    for (int i = 0; i < 3; ++i) {
                        box.min[i] = tree.centre()[i] + boxes.c[i][k] - boxes.h[i][k] - slack;
                        box.max[i] = tree.centre()[i] + boxes.c[i][k] + boxes.h[i][k] + slack;
                    }
                    around.push_back(box);
                    if (masks.leaves >> k & 1) {
                        for (const std::uint32_t t : tree.primitives(node, k)) {
                            ++seen[t];
                            for (const Vector3d& p : tree.points(t))
                                for (const Aabb& outer : around) EXPECT_TRUE(outer.contains(Aabb{p, p}));
                        }
                    } else {
                        down(tree.child(node, k));
                    }
                    around.pop_back();
                }
            };
            down(TerrainTree::root);
            for (std::uint32_t y = 0; y < terrain.cells_y(); ++y)
                for (std::uint32_t x = 0; x < terrain.cells_x(); ++x)
                    for (std::uint32_t half = 0; half < 2; ++half)
                        EXPECT_EQ(seen[2 * (y * terrain.cells_x() + x) + half], terrain.has_cell(x, y));
        }
}

TEST(TerrainTree, StartsAtANodeThatHoldsAllThatIsInTheBoxAndLittleElse)
{
    const Terrain terrain = random_terrain(130, 67, 0.1, 1);
    const TerrainTree tree(terrain);
    double cells = 0;
    for (std::uint64_t seed = 0; seed < 500; ++seed) {
        const Vector3d middle(1000 + 15 * u01(seed, 0, 0) - 1, -2000 + 15 * u01(seed, 0, 1) - 1, 5 + u01(seed, 0, 2));
        const double out = 0.5 * u01(seed, 0, 3);
        const Aabb box{middle.array() - out, middle.array() + out};
        const TerrainTree::Entry entry = tree.entry(box);
        std::vector<bool> in(std::size_t(terrain.cells_x()) * terrain.cells_y());
        if (entry.node) {
            const std::function<void(const TerrainTree::Node&)> down = [&](const TerrainTree::Node& node) {
                OpenBoxes boxes;
                const LaneMasks masks = tree.open(node, nullptr, boxes);
                if (&node == &*entry.node) {
                    EXPECT_GT(boxes.c[0][1], 1e29f) << "one box, in lane 0";
                }
                for (unsigned k = 0; k < 8; ++k) {
                    if (boxes.c[0][k] > 1e29f) continue;
                    if (masks.leaves >> k & 1)
                        in[tree.primitives(node, k)[0] / 2] = true;
                    else
                        down(tree.child(node, k));
                }
            };
            down(*entry.node);
        }
        for (std::uint32_t y = 0; y < terrain.cells_y(); ++y)
            for (std::uint32_t x = 0; x < terrain.cells_x(); ++x) {
                if (in[y * terrain.cells_x() + x] || !terrain.has_cell(x, y)) continue;
                Aabb cell{{terrain.x(x), terrain.y(y), terrain.bounds().min.z()},
                          {terrain.x(x + 1), terrain.y(y + 1), terrain.bounds().max.z()}};
                const Vector3d apart = (cell.min - box.max).cwiseMax(box.min - cell.max);
                EXPECT_GE(apart.maxCoeff(), entry.gap) << seed;
            }
        cells += double(std::count(in.begin(), in.end(), true));
    }
    EXPECT_LT(cells / 500, 700);
}

template <class A, class B>
void compare_with_brute_force(A& a, std::uint32_t triangles_a, B& b, std::uint32_t triangles_b, auto there,
                              const RelativePose& b_to_a, int& met)
{
    TriangleTestsOf<A, B> truth;
    truth.start(a, b, b_to_a);
    std::vector<TrianglePair> pairs, found;
    double distance = std::numeric_limits<double>::infinity();
    for (std::uint32_t s = 0; s < triangles_a; ++s)
        for (std::uint32_t t = 0; t < triangles_b; ++t) {
            const TrianglePair pair{s, t};
            if (!there(pair)) continue;
            if (truth.meet(pair))
                pairs.push_back(pair), distance = 0;
            else if (distance > 0)
                distance = std::min(distance, truth.nearest(pair, 0x1p-40).distance);
        }
    met += !pairs.empty();
    TraversalOf<A, B> walk;
    walk.all_meeting(a, b, b_to_a, found);
    EXPECT_EQ(found, pairs);
    const auto first = walk.first_meeting(a, b, b_to_a);
    EXPECT_EQ(first.pair.has_value(), !pairs.empty());
    if (pairs.empty()) {
        EXPECT_GT(first.bound, 0);
        EXPECT_LE(first.bound, distance);
    }
    const auto bounds = walk.distance(a, b, b_to_a, 0);
    EXPECT_NEAR(bounds.lower, distance, 1e-9);
    EXPECT_NEAR(bounds.upper, distance, 1e-9);
    for (const double clearance : {0.0, 0.05, 0.3}) {
        const auto near = walk.near(a, b, b_to_a, clearance, 0.01);
        if (distance <= clearance) {
            EXPECT_TRUE(near.near);
        }
        EXPECT_TRUE(near.near ? distance <= near.bound : near.bound <= distance);
    }
}

TEST(TerrainTree, WalksFindWhatBruteForceFinds)
{
    const Mesh knot = make_torus_knot_mesh(2, 3, 0.5, 0.2, 0.08, 60);
    ObbTree mesh(knot);
    int met = 0, all = 0;
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        const Terrain terrain = random_terrain(20, 12, seed % 2 ? 0.1 : 0, seed);
        TerrainTree tree(terrain);
        const std::uint32_t triangles = 2 * terrain.cells_x() * terrain.cells_y();
        const auto there = [&](std::uint32_t t) {
            return terrain.has_cell(t / 2 % terrain.cells_x(), t / 2 / terrain.cells_x());
        };
        const Isometry3d stay = Isometry3d::Identity(),
                         moved = Eigen::Translation3d(1001, -1999, 5.5) * random_pose(seed, 1.5);
        compare_with_brute_force(
            tree, triangles, mesh, 60, [&](TrianglePair p) { return there(p.a); }, RelativePose(stay, moved), met);
        compare_with_brute_force(
            mesh, 60, tree, triangles, [&](TrianglePair p) { return there(p.b); }, RelativePose(moved, stay), met);
        const Terrain small = random_terrain(5, 4, 0, seed);
        TerrainTree other(small);
        compare_with_brute_force(
            tree, triangles, other, 24, [&](TrianglePair p) { return there(p.a); },
            RelativePose(stay, moved * Eigen::Translation3d(-1000.2, 2000.3, -5.5)), met);
        all += 3;
    }
    EXPECT_GT(met, all / 5);
    EXPECT_LT(met, all * 4 / 5);
}

/// A sphere of 1 m on 300 by 300 cells of 40 m: contacts of a traversal, compared with the cells around it, and the
/// number of triangles that it tests.
template <class Ground>
void stand_on(Ground& ground, const Terrain& terrain, std::uint64_t seed, bool ball_first)
{
    const Mesh ball = make_sphere_mesh(1, 500);
    ObbTree tree(ball);
    const auto column = static_cast<std::uint32_t>(2 + 290 * u01(seed, 1, 0)),
               row = static_cast<std::uint32_t>(2 + 290 * u01(seed, 1, 1));
    const Vector3d place = terrain.point(column, row) + Vector3d(20 * u01(seed, 1, 2), 20 * u01(seed, 1, 3), 30);
    const Isometry3d turn = random_pose(seed, 1e4); // rotation of both bodies
    const Isometry3d spin = random_pose(seed + 1, 0);
    std::vector<TrianglePoints> near;
    for (std::uint32_t y = row - 1; y < row + 2; ++y)
        for (std::uint32_t x = column - 1; x < column + 2; ++x)
            for (std::uint32_t half = 0; half < 2; ++half) {
                const auto corners = terrain.corners(2 * (y * terrain.cells_x() + x) + half);
                near.emplace_back();
                for (std::size_t k = 0; k < 3; ++k) near.back()[k] = terrain.point(corners[k].column, corners[k].row);
            }
    const auto truth = [&](const RelativePose& ball_to_ground) {
        double distance = std::numeric_limits<double>::infinity();
        for (const Triangle& t : ball.triangles) {
            TrianglePoints moved;
            for (std::size_t k = 0; k < 3; ++k) moved[k] = ball_to_ground(ball.vertices[t[k]]);
            for (const TrianglePoints& below : near)
                distance = triangles_meet(moved, below) ? 0 : std::min(distance, triangle_distance(moved, below));
        }
        return distance;
    };
    const auto pose = [&](double up) {
        return Isometry3d(turn * Eigen::Translation3d(place.x(), place.y(), up) * spin);
    };
    double up = place.z(); // of the sphere's centre: lowered to the ground by distances
    for (double left = 1; left > 1e-9; up -= left) left = truth(RelativePose(turn, pose(up)));
    for (const double deep : {-0.3, -1e-3, -1e-6, 1e-6, 1e-3}) {
        const Isometry3d at = pose(up - deep);
        const double distance = truth(RelativePose(turn, at));
        const auto check = [&](auto& walk, auto& a, auto& b, const RelativePose& b_to_a) {
            const auto first = walk.first_meeting(a, b, b_to_a);
            EXPECT_EQ(first.pair.has_value(), distance == 0) << seed << ' ' << deep;
            EXPECT_LE(first.bound, distance * (1 + 1e-6) + 1e-8);
            EXPECT_LE(walk.counts().triangles, 32u) << deep;
            const auto bounds = walk.distance(a, b, b_to_a, 0);
            EXPECT_NEAR(bounds.lower, distance, 1e-6) << seed << ' ' << deep;
            EXPECT_NEAR(bounds.upper, distance, 1e-6) << seed << ' ' << deep;
            EXPECT_EQ(walk.near(a, b, b_to_a, std::max(distance * (1 - 1e-5) - 4e-7, 0.0), 0).near, distance == 0);
            EXPECT_TRUE(walk.near(a, b, b_to_a, distance * (1 + 1e-5) + 4e-7, 0).near);
        };
        if (ball_first) {
            TraversalOf<ObbTree, Ground> walk;
            check(walk, tree, ground, RelativePose(at, turn));
        } else {
            TraversalOf<Ground, ObbTree> walk;
            check(walk, ground, tree, RelativePose(turn, at));
        }
    }
}

TEST(TerrainTree, AWalkSeesWhatStandsOnItToFractionsOfTheBodyHoweverLargeTheTerrainIs)
{
    TerrainGrid grid{.columns = 301, .rows = 301};
    grid.spacing = {40, 40}, grid.origin = {-3000, 2000, 500};
    std::vector<double> heights;
    for (std::uint64_t i = 0; i < 301 * 301; ++i) heights.push_back(5.0 * double(i / 301) + 8 * u01(7, i, 1));
    const Terrain terrain = make_terrain("mountains", grid, heights);
    const Mesh mesh = mesh_of(terrain);
    TerrainTree grid_tree(terrain);
    ObbTree mesh_tree(mesh);
    for (std::uint64_t seed = 0; seed < 3; ++seed)
        for (const bool ball_first : {false, true}) {
            stand_on(grid_tree, terrain, seed, ball_first);
            stand_on(mesh_tree, terrain, seed, ball_first);
        }
}

TEST(TerrainTree, NamesABlockThatDoesNotEncloseTheTerrain)
{
    for (const auto& [columns, rows] : {Size{2, 2}, Size{3, 40}, Size{9, 9}, Size{130, 67}}) {
        Terrain terrain = random_terrain(columns, rows, columns < 5 ? 0 : 0.2, 3);
        const TerrainTree tree(terrain);
        EXPECT_EQ(tree.validate(), "");
        TerrainGrid grid{.columns = columns, .rows = rows};
        grid.spacing = terrain.spacing(), grid.origin = terrain.origin(), grid.no_data = -1;
        std::vector<double> heights;
        for (std::uint32_t row = 0; row < rows; ++row)
            for (std::uint32_t column = 0; column < columns; ++column) {
                const double height = terrain.height(column, row);
                heights.push_back(std::isnan(height) ? -1 : height);
            }
        heights.back() = heights[heights.size() - 2] = heights[heights.size() - columns - 1] =
            heights[heights.size() - columns - 2] = 1.5; // above all others, and no hole
        terrain = make_terrain("raised", grid, heights); // the tree refers to it
        EXPECT_NE(tree.validate().find("corner of cell"), std::string::npos) << tree.validate();
    }
}

} // namespace
} // namespace oncollide
