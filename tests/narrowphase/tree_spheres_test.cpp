// What a whole tree says about a surface, judged by code that shares nothing with the trees.
#include <gtest/gtest.h>

#include "narrowphase/octant_truth.hpp"
#include "sphere_quality.hpp"
#include <oncollide/narrowphase/tree_spheres.hpp>

namespace oncollide {
namespace {

using Eigen::Vector3d;

/// A tree grown whole, with tight bounds; its cells by level.
struct WholeTree {
    explicit WholeTree(const Mesh& mesh, int depth)
        : geometry{"mesh", mesh, {}}, tree(root_cell_of(geometry), depth, 0, {.tight_levels = depth}),
          backend(make_cpu_backend()), levels{{root_cell}}
    {
        backend->attach(0, make_surface(geometry, tree.root()));
        for (int l = 0; l < depth; ++l) {
            std::vector<OctantRow> rows;
            for (const CellKey cell : levels.back()) rows.push_back(tree.row(0, cell));
            std::vector<OctantAnswer> answers(rows.size());
            backend->ask(rows, 1, answers);
            for (std::size_t i = 0; i < rows.size(); ++i) tree.expand(rows[i].cell, answers[i], 1);
            levels.emplace_back();
            tree.for_each_cell([&](CellKey cell, bool) {
                if (level_of(cell) == l + 1) levels.back().push_back(cell);
            });
        }
    }

    std::vector<TreeSphere> spheres(int level, bool tight, bool slab) const
    {
        std::vector<TreeSphere> all;
        for (const CellKey cell : levels[std::size_t(level)]) {
            all.push_back(tight ? tight_sphere(tree, cell) : plain_sphere(tree, cell));
            if (!slab) all.back().half = all.back().radius;
        }
        return all;
    }

    Geometry geometry;
    Ocst tree;
    std::unique_ptr<OcclusionBackend> backend;
    std::vector<std::vector<CellKey>> levels;
};

std::vector<Case> hard_cases()
{
    std::vector<Case> all;
    for (Case& c : cases())
        if (c.mesh.triangles.size() < 4000) all.push_back(std::move(c)); // each level is judged: the larger take long
    all.push_back(
        {"slivers, 1 : 1e12", make_mesh("slivers", {{0, 0, 0}, {1, 0.3, 0.2}, {0.5, 0.15 + 1e-12, 0.1}, {0.2, 1, 0.7}},
                                        {{0, 1, 2}, {0, 2, 3}, {0, 0, 3}, {3, 3, 3}})});
    all.push_back({"one triangle", make_mesh("one", {{0, 0, 0}, {1, 0.1, 0.4}, {0.3, 0.9, 1}}, {{0, 1, 2}})});
    return all;
}

TEST(TreeSpheres, HoldTheWholeSurfaceOnEveryLevelAndReachNoFartherThanCertified)
{
    for (const Case& c : hard_cases()) {
        const int depth = c.mesh.triangles.size() < 100 ? 5 : 4;
        const WholeTree whole(c.mesh, depth);
        const tools::TriangleTree triangles(c.mesh);
        for (int level = 0; level <= depth; ++level) {
            const double certified = 2 * whole.tree.radius(level) + whole.tree.reach(*whole.backend, level);
            for (const auto& [kind, tight, slab] :
                 {std::tuple{"plain", false, true}, {"ball", true, false}, {"disc", true, true}}) {
                SCOPED_TRACE(c.name + ", " + kind + ", level " + std::to_string(level));
                const auto quality = tools::judge_spheres(c.mesh, triangles, whole.spheres(level, tight, slab),
                                                          {.directions = 20, .points = 5000});
                EXPECT_EQ(quality.open_triangles, 0u);
                EXPECT_EQ(quality.uncovered, 0);
                EXPECT_EQ(quality.outside, 0u);
                EXPECT_GE(quality.points, 4 * c.mesh.triangles.size());
                EXPECT_LE(quality.worst, certified);
            }
        }
    }
}

TEST(TreeSpheres, TightOnesAreNoLargerAndLeaveLessOfACurvedSurfacesNeighbourhood)
{
    const Mesh mesh = make_sphere_mesh(1, 20000);
    const WholeTree whole(mesh, 5);
    const auto plain = whole.spheres(5, false, true), tight = whole.spheres(5, true, true);
    ASSERT_EQ(plain.size(), tight.size());
    for (std::size_t i = 0; i < plain.size(); ++i) {
        EXPECT_LE(tight[i].radius, plain[i].radius);
        EXPECT_LE(tight[i].half, tight[i].radius);
    }
    const tools::TriangleTree triangles(mesh);
    const tools::QualityOptions options{.closed = true, .directions = 20, .points = 0};
    const auto quality = tools::judge_spheres(mesh, triangles, plain, options);
    const auto better = tools::judge_spheres(mesh, triangles, tight, options);
    // The octree's law: beyond a closed surface the mean tends to the radius and the worst to twice as much.
    const double radius = whole.tree.radius(5);
    EXPECT_NEAR(quality.mean_beyond, radius, 0.1 * radius);
    EXPECT_GT(quality.worst_beyond, 1.6 * radius);
    EXPECT_LT(better.mean_beyond, 0.4 * radius);
    EXPECT_LT(better.volume, 0.4 * quality.volume);
}

// How many cells a surface enters follows from geometry where its faces lie on the faces of cells: these belong to the
// cells on both sides.

TEST(TreeSpheres, OfABoxAreTheCellsOfItsHull)
{
    const WholeTree whole(make_box_mesh({1, 2, 3}), 4);
    for (int level = 0; level <= 4; ++level) {
        const std::size_t n = std::size_t(1) << level, inner = n < 2 ? 0 : n - 2;
        EXPECT_EQ(whole.levels[std::size_t(level)].size(), n * n * n - inner * inner * inner) << "level " << level;
    }
}

TEST(TreeSpheres, OfOneTriangleAreTheSquaresBelowItsDiagonalOnBothSides)
{
    const WholeTree whole(make_mesh("half a square", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}), 5);
    for (int level = 1; level <= 5; ++level) {
        const std::size_t n = std::size_t(1) << level; // squares (i, j) with i + j <= n: the last touch in a corner
        EXPECT_EQ(whole.levels[std::size_t(level)].size(), 2 * (n * (n + 1) / 2 + n - 1)) << "level " << level;
    }
}

} // namespace
} // namespace oncollide
