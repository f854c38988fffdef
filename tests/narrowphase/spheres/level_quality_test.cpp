// The statements of a whole tree about a surface, checked by code that shares nothing with the trees.
#include <gtest/gtest.h>

#include "narrowphase/octant_truth.hpp"
#include "trees/box_levels.hpp"
#include "trees/grown_tree.hpp"
#include "trees/level_quality.hpp"

namespace oncollide {
namespace {

using Eigen::Vector3d;
using tools::CoveringVolume;

tools::GrownTree whole_tree(Mesh mesh, int depth)
{
    return {std::make_shared<Geometry>(Geometry{"mesh", std::move(mesh), {}}), {.depth = depth}};
}

std::vector<Case> hard_cases()
{
    std::vector<Case> all;
    for (Case& c : cases())
        if (c.mesh.triangles.size() < 4000) all.push_back(std::move(c)); // larger meshes take long
    all.push_back(
        {"slivers, 1 : 1e12", make_mesh("slivers", {{0, 0, 0}, {1, 0.3, 0.2}, {0.5, 0.15 + 1e-12, 0.1}, {0.2, 1, 0.7}},
                                        {{0, 1, 2}, {0, 2, 3}, {0, 0, 3}, {3, 3, 3}})});
    all.push_back({"one triangle", make_mesh("one", {{0, 0, 0}, {1, 0.1, 0.4}, {0.3, 0.9, 1}}, {{0, 1, 2}})});
    return all;
}

void expect_to_stand_for(const Mesh& mesh, const tools::SurfaceIndex& index, std::span<const CoveringVolume> volumes,
                         double certified)
{
    const auto quality = tools::judge_level(mesh, index, volumes, {.directions = 20, .points = 5000});
    EXPECT_EQ(quality.open_triangles, 0u);
    EXPECT_EQ(quality.uncovered, 0);
    EXPECT_EQ(quality.outside, 0u);
    EXPECT_GE(quality.points, 4 * mesh.triangles.size());
    EXPECT_LE(quality.worst.either, certified);
}

TEST(WholeTrees, SpheresHoldTheSurfaceOnEveryLevelAndReachNoFartherThanCertified)
{
    for (const Case& c : hard_cases()) {
        const int depth = c.mesh.triangles.size() < 100 ? 5 : 4;
        const tools::GrownTree whole = whole_tree(c.mesh, depth);
        const tools::SurfaceIndex index(c.mesh);
        for (int level = 0; level <= depth; ++level) {
            SCOPED_TRACE(c.name + ", level " + std::to_string(level));
            expect_to_stand_for(c.mesh, index, whole.spheres(level), whole.certified_reach(level));
        }
    }
}

TEST(WholeTrees, BoxesHoldTheSurfaceOnEveryLevelAndReachNoFartherThanTheyAreLong)
{
    for (const Case& c : hard_cases()) {
        ObbTree tree(c.mesh);
        const auto levels = tools::box_levels(tree);
        EXPECT_EQ(levels.back().size(), c.mesh.triangles.size()) << c.name;
        EXPECT_LE(tree.nodes(), ObbTree::most_nodes(c.mesh.triangles.size()));
        const tools::SurfaceIndex index(c.mesh);
        for (std::size_t level = 0; level < levels.size(); ++level) {
            SCOPED_TRACE(c.name + ", level " + std::to_string(level));
            double radius = 0;
            for (const CoveringVolume& box : levels[level]) {
                radius = std::max(radius, box.radius());
                EXPECT_TRUE((box.axes.transpose() * box.axes).isIdentity(4e-6));
                EXPECT_NEAR(box.axes.determinant(), 1, 4e-6);
            }
            expect_to_stand_for(c.mesh, index, levels[level], 2 * radius * (1 + 1e-6));
        }
    }
}

TEST(WholeTrees, BoxesLeaveLessOfACurvedSurfacesNeighbourhoodThanAsManySpheres)
{
    const Mesh mesh = make_sphere_mesh(1, 40000);
    const tools::GrownTree whole = whole_tree(mesh, 5);
    const auto spheres = whole.spheres(5);
    ObbTree tree(mesh);
    const auto boxes = tools::box_levels(tree).at(4);
    ASSERT_EQ(boxes.size(), 4096u);
    ASSERT_GT(spheres.size(), boxes.size());
    const tools::SurfaceIndex index(mesh);
    const tools::QualityOptions options{.closed = true, .directions = 20, .points = 0};
    const auto quality = tools::judge_level(mesh, index, spheres, options);
    const auto better = tools::judge_level(mesh, index, boxes, options);
    // A property of the octree: outside a closed surface the mean excess approaches the radius, and the maximum twice
    // the radius.
    const double radius = whole.tree().radius(5);
    EXPECT_NEAR(quality.mean.beyond, radius, 0.1 * radius);
    EXPECT_GT(quality.worst.beyond, 1.6 * radius);
    EXPECT_LT(better.mean.beyond, 0.05 * radius);
    EXPECT_LT(better.worst.beyond, 0.2 * radius);
    EXPECT_LT(better.volume, 0.05 * quality.volume);
}

// If the faces of a surface are on the faces of cells, the number of cells that it enters follows from geometry: such
// faces belong to the cells on both sides.

TEST(WholeTrees, SpheresOfABoxAreTheCellsOfItsHull)
{
    const tools::GrownTree whole = whole_tree(make_box_mesh({1, 2, 3}), 4);
    for (int level = 0; level <= 4; ++level) {
        const std::size_t n = std::size_t(1) << level, inner = n < 2 ? 0 : n - 2;
        EXPECT_EQ(whole.level(level).size(), n * n * n - inner * inner * inner) << "level " << level;
    }
}

TEST(WholeTrees, SpheresOfOneTriangleAreTheSquaresBelowItsDiagonalOnBothSides)
{
    const tools::GrownTree whole =
        whole_tree(make_mesh("half a square", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}), 5);
    for (int level = 1; level <= 5; ++level) {
        const std::size_t n = std::size_t(1) << level; // squares (i, j) with i + j <= n: the last squares touch at a
                                                       // corner
        EXPECT_EQ(whole.level(level).size(), 2 * (n * (n + 1) / 2 + n - 1)) << "level " << level;
    }
}

} // namespace
} // namespace oncollide
