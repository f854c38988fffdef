// Distances of convex solids from terrains and meshes: the traversal with its bounds, compared with every triangle.
#include <algorithm>
#include <cstring>
#include <functional>
#include <memory>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <oncollide/base/simd/cpu_features.hpp>
#include <oncollide/narrowphase/walks/solid_distance.hpp>
#include <oncollide/samples/generators.hpp>

#include "random_pose.hpp"

namespace oncollide {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

enum class Ground { level, slope, hills, rough, cliffs, holes, mixed };
constexpr Ground every_ground[] = {Ground::level,  Ground::slope, Ground::hills, Ground::rough,
                                   Ground::cliffs, Ground::holes, Ground::mixed};

/// @param size  of a cell, metres
Terrain terrain_of(Ground kind, std::uint32_t columns, std::uint32_t rows, double size, std::uint64_t seed)
{
    TerrainGrid grid{.columns = columns, .rows = rows};
    grid.spacing = {size, 1.5 * size}, grid.origin = {1000 * size, -2000 * size, 5 * size};
    grid.bytes = 8;
    if (kind == Ground::holes) grid.no_data = -1;
    if (kind == Ground::mixed)
        for (std::uint32_t i = 0; i < (columns - 1) * (rows - 1); ++i) grid.falling.push_back(u01(seed, i, 3) < 0.5);
    std::vector<double> heights;
    for (std::uint32_t y = 0; y < rows; ++y)
        for (std::uint32_t x = 0; x < columns; ++x) {
            const double any = u01(seed, std::uint64_t(y) * columns + x, 1);
            switch (kind) {
            case Ground::level:
                heights.push_back(0.5 * size);
                break;
            case Ground::slope:
                heights.push_back((0.7 * x - 0.3 * y) * size);
                break;
            case Ground::hills:
                heights.push_back(3 * size * (std::sin(0.3 * x) + std::cos(0.2 * y)));
                break;
            case Ground::cliffs:
                heights.push_back(any < 0.1 ? 100 * size : 0);
                break;
            case Ground::holes:
                heights.push_back(any < 0.2 ? -1 : any * size);
                break;
            default:
                heights.push_back(any * size);
            }
        }
    return make_terrain("ground", grid, heights);
}

struct Solid {
    Convex convex;
    Aabb bounds;
    std::unique_ptr<Mesh> surface; ///< of a hull
};

constexpr int kinds = 7;
Solid solid_of(int kind, double size)
{
    const auto of = [&](const Shape& shape, const Vector3d& half) {
        return Solid{convex_of(shape), Aabb{-half, half}, nullptr};
    };
    switch (kind) {
    case 0:
        return of(Sphere{size}, Vector3d::Constant(size));
    case 1:
        return of(Box{{size, 0.3 * size, 0.01 * size}}, {size, 0.3 * size, 0.01 * size});
    case 2:
        return of(Capsule{0.1 * size, 2 * size}, {0.1 * size, 0.1 * size, 1.1 * size});
    case 3:
        return of(Cylinder{size, 0.5 * size}, {size, size, 0.25 * size});
    case 4:
        return of(Ellipsoid{{size, 0.1 * size, 0.4 * size}}, {size, 0.1 * size, 0.4 * size});
    case 5:
        return of(Cone{size, size}, {size, size, 0.5 * size});
    default:
        break;
    }
    auto surface = std::make_unique<Mesh>(make_sphere_mesh(size, 60)); // not centred at the origin
    for (Vector3d& v : surface->vertices) v = v.cwiseProduct(Vector3d(1, 0.2, 0.7)) + Vector3d(3, 0, 0) * size;
    Solid hull{convex_of_hull(*surface), {}, nullptr};
    for (const Vector3d& v : surface->vertices) hull.bounds.add(v);
    hull.surface = std::move(surface);
    return hull;
}

struct Truth {
    double lower = infinity, upper = infinity;
};

/// @param there  whether the triangle exists
template <class Tree>
Truth truth_of(const Solid& solid, const Tree& tree, std::uint32_t triangles, auto there, const RelativePose& into)
{
    TriangleCorners<Tree> corners;
    corners.start(tree);
    Truth truth;
    for (std::uint32_t t = 0; t < triangles; ++t) {
        if (!there(t)) continue;
        const TrianglePoints points = corners.points(t);
        const Convex triangle = convex_of(points);
        const ConvexDistance d = ConvexPair(solid.convex, triangle, into, 0x1p-49).distance({});
        truth.lower = std::min(truth.lower, d.lower), truth.upper = std::min(truth.upper, d.upper);
    }
    return truth;
}

template <class Tree>
void expect_certified(const Solid& solid, Tree& tree, const Truth& truth, const RelativePose& into, double size)
{
    SolidDistance<Tree> walk;
    const ShapeTree shape(solid.convex, solid.bounds);
    const double rounding = 1e-9 * (size + truth.upper) + 1e-13 * into.translation.norm();
    for (const double tolerance : {0.0, 0.3 * size, 10 * size}) {
        const auto d = walk.distance(shape, tree, into, 0x1p-49, tolerance, infinity);
        EXPECT_LE(d.lower, truth.upper);
        EXPECT_GE(d.upper, truth.lower);
        EXPECT_LE(d.lower, d.upper);
        EXPECT_LE(d.upper - d.lower, tolerance + truth.upper - truth.lower + rounding) << tolerance;
        ASSERT_TRUE(d.nearest.has_value());
        TriangleCorners<Tree> corners;
        corners.start(tree);
        const TrianglePoints points = corners.points(d.nearest->b);
        const Convex triangle = convex_of(points);
        EXPECT_NEAR(ConvexPair(solid.convex, triangle, into, 0x1p-49).distance({}).upper, d.upper, rounding);
    }
    for (const double share : {0.3, 0.999, 1.001, 5.0}) {
        const double farthest = share * truth.upper;
        const auto d = walk.distance(shape, tree, into, 0x1p-49, 0, farthest);
        EXPECT_LE(d.lower, truth.upper);
        if (farthest > truth.upper + rounding) {
            EXPECT_LE(d.upper, truth.upper + rounding);
        }
        if (farthest < truth.lower - rounding) {
            EXPECT_GT(d.lower, farthest);
            EXPECT_EQ(d.upper, infinity);
        }
    }
}

class SolidDistances : public ::testing::TestWithParam<Ground> {};

TEST_P(SolidDistances, AreThoseOfTheNearestTriangle)
{
    int met = 0, apart = 0;
    for (std::uint64_t seed = 0; seed < 42; ++seed) {
        const double size = std::pow(10, std::array{0, 9, -9}[seed % 3]);
        const Terrain terrain = terrain_of(GetParam(), 21, 18, size, seed);
        const Mesh mesh = mesh_of(terrain);
        TerrainTree heights(terrain);
        ObbTree boxes(mesh);
        const Solid solid = solid_of(int(seed / 3) % kinds, size * (seed % 2 ? 0.5 : 3));
        // Beside a corner of a triangle, above its centre, and far away; with the ground far from the world's origin.
        for (const double away : {0.0, 1.0, 6.0, 1000.0}) {
            const Vector3d over = terrain.bounds().centre();
            Isometry3d pose = random_pose(seed + 100 * std::uint64_t(away), 0);
            pose.translation() =
                over + away * size * Vector3d(u01(seed, 1, 1) - 0.5, u01(seed, 1, 2) - 0.5, u01(seed, 1, 3));
            pose.translation().z() = std::max(pose.translation().z(), terrain.bounds().max.z() + 0.4 * away * size);
            const Isometry3d world = random_pose(seed + 7, seed % 4 ? 0 : 1e5 * size);
            const RelativePose into(world * pose, world);
            SCOPED_TRACE(fmt::format("seed {}, cells of {} m, {} away", seed, size, away));
            const auto cell_is_there = [&](std::uint32_t t) {
                return terrain.has_cell(t / 2 % terrain.cells_x(), t / 2 / terrain.cells_x());
            };
            const Truth truth =
                truth_of(solid, heights, 2 * terrain.cells_x() * terrain.cells_y(), cell_is_there, into);
            (truth.upper > 0 ? apart : met)++;
            expect_certified(solid, heights, truth, into, size);
            expect_certified(solid, boxes, truth, into, size);
        }
    }
    EXPECT_GT(met, 0);
    EXPECT_GT(apart, 60);
}

INSTANTIATE_TEST_SUITE_P(Grounds, SolidDistances, ::testing::ValuesIn(every_ground));

/// Needles, and triangles without area, in all directions.
TEST(SolidDistance, OfSliversIsCertifiedToo)
{
    for (std::uint64_t seed = 0; seed < 70; ++seed) {
        const double size = std::pow(10, std::array{0, 9, -9}[seed % 3]);
        Mesh mesh = make_soup_mesh(40, 3 * size, 2 * size, seed);
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
            Vector3d& last = mesh.vertices[mesh.triangles[t][2]];
            const Vector3d &first = mesh.vertices[mesh.triangles[t][0]], &next = mesh.vertices[mesh.triangles[t][1]];
            last = t % 3 ? Vector3d(first + 0.3 * (next - first) + 1e-9 * (last - first)) : next;
        }
        mesh = make_mesh("slivers", std::move(mesh.vertices), std::move(mesh.triangles));
        ObbTree tree(mesh);
        const Solid solid = solid_of(int(seed) % kinds, size);
        const RelativePose into(random_pose(seed, (seed % 5 ? 5 : 500) * size), Isometry3d::Identity());
        SCOPED_TRACE(seed);
        const Truth truth = truth_of(
            solid, tree, std::uint32_t(mesh.triangles.size()), [](std::uint32_t) { return true; }, into);
        expect_certified(solid, tree, truth, into, size);
    }
}

TEST(SolidDistance, OverLargeGroundTakesFewNodes)
{
    for (const Ground kind : {Ground::level, Ground::slope, Ground::hills}) {
        const Terrain terrain = terrain_of(kind, 400, 300, 1, 1);
        const Mesh mesh = mesh_of(terrain);
        TerrainTree heights(terrain);
        ObbTree boxes(mesh);
        for (const double away : {0.5, 20.0, 500.0})
            for (const int which : {0, 1, 3}) {
                const Solid solid = solid_of(which, 0.7);
                const ShapeTree shape(solid.convex, solid.bounds);
                Isometry3d pose = random_pose(std::uint64_t(which), 0);
                pose.translation() = terrain.bounds().centre() + Vector3d(20.3, 11.7, 0);
                pose.translation().z() = terrain.bounds().max.z() + away;
                const RelativePose into(pose, Isometry3d::Identity());
                const auto look = [&](auto walk, auto& tree) {
                    walk.distance(shape, tree, into, 0x1p-49, 0, infinity);
                    EXPECT_LE(walk.nodes, 60u) << int(kind) << ' ' << away << ' ' << which;
                    EXPECT_LE(walk.triangles, 40u) << int(kind) << ' ' << away << ' ' << which;
                };
                look(SolidDistance<TerrainTree>(), heights);
                look(SolidDistance<ObbTree>(), boxes);
            }
    }
}

/// The heights of all cells below a node are between the planes of its blocks.
TEST(SolidDistance, BlocksHoldTheirHeightsBetweenTwoPlanes)
{
    for (const Ground kind : every_ground) {
        const Terrain terrain = terrain_of(kind, 150, 77, 1, 3);
        const TerrainTree tree(terrain);
        const Vector3d from = terrain.bounds().centre() + Vector3d(3, -4, 5);
        double thick = 0, high = 0;
        std::size_t blocks = 0;
        std::function<std::vector<Vector3d>(const TerrainTree::Node&)> below = [&](const TerrainTree::Node& node) {
            std::vector<Vector3d> all;
            if (node.level == 0 && !node.whole) {
                for (unsigned k = 0; k < 8; ++k) {
                    const std::uint32_t x = node.x + k % 4, y = node.y + k / 4;
                    if (x >= terrain.cells_x() || y >= terrain.cells_y() || !terrain.has_cell(x, y)) continue;
                    for (unsigned c = 0; c < 4; ++c) all.push_back(terrain.point(x + c % 2, y + c / 2) - from);
                }
                return all;
            }
            TerrainBlocks of{};
            tree.open_blocks(node, from, of);
            const unsigned w = of.wide ? 4 : 2;
            for (unsigned k = 0; k < 8; ++k) {
                if (!(of.low[k] <= of.high[k] && of.x[k % w] < of.x[k % w + 1] && of.y[k / w] < of.y[k / w + 1]))
                    continue;
                const double slack = 1e-5 * (1 + terrain.bounds().diagonal());
                const double middle_x = of.one_slope ? of.x[0] + 2 * of.half_x : of.x[k % w] + of.half_x,
                             middle_y = of.one_slope ? of.y[0] + 4 * of.half_y : of.y[k / w] + of.half_y;
                const std::vector<Vector3d> in = below(tree.child(node, k));
                EXPECT_TRUE(!in.empty() || kind == Ground::holes);
                for (const Vector3d& p : in) {
                    EXPECT_TRUE(p.x() >= of.x[k % w] - slack && p.x() <= of.x[k % w + 1] + slack);
                    EXPECT_TRUE(p.y() >= of.y[k / w] - slack && p.y() <= of.y[k / w + 1] + slack);
                    EXPECT_TRUE(p.z() >= of.zero + of.low[k] - slack && p.z() <= of.zero + of.high[k] + slack);
                    const double above =
                        p.z() - of.zero - of.slope_x[k] * (p.x() - middle_x) - of.slope_y[k] * (p.y() - middle_y);
                    EXPECT_GE(above, of.slab_low[k] - slack) << node.level;
                    EXPECT_LE(above, of.slab_high[k] + slack) << node.level;
                }
                thick += of.slab_high[k] - of.slab_low[k], high += of.high[k] - of.low[k], ++blocks;
                all.insert(all.end(), in.begin(), in.end());
            }
            return all;
        };
        below(tree.child(TerrainTree::root, 0));
        EXPECT_GT(blocks, 1000u);
        if (kind == Ground::slope) {
            EXPECT_LT(thick, 0.1 * high);
        }
    }
}

TEST(SolidDistance, GapsAreAlikeOnEveryInstructionSet)
{
    const Terrain terrain = terrain_of(Ground::holes, 50, 40, 1, 2);
    const TerrainTree heights(terrain);
    const Mesh mesh = mesh_of(terrain);
    const ObbTree boxes(mesh);
    SolidReach reach{{0.1f, 0.2f, -0.3f}, {{0.6f, 0, 0.8f}, {0, 1, 0}, {-0.8f, 0, 0.6f}}, {1, 2, 0}, {3, 0, 1}, 0.5f};
    const BoxLine line{{0.6f, -0.48f, -0.64f}, 1.5f};
    struct Gaps {
        float of[5][8];
        std::uint32_t near[3];
    };
    const auto look = [&](const SolidGapKernel& kernel, std::uint32_t k) {
        Gaps gaps{};
        std::fill_n(gaps.of[4], 8, 1e30f);
        const Vector3d from = terrain.bounds().centre() + Vector3d(0, k % 7, 3 + 5.0 * k);
        const float cutoff = 0.3f * float(k) * 5;
        TerrainCells cells{};
        heights.open_cells({4 * (k % 13), 2 * (k % 20), 0, false}, from, cells);
        float(&of_cells)[2][8] = reinterpret_cast<float(&)[2][8]>(gaps.of[0]);
        float apart = 1e30f;
        gaps.near[0] = kernel.of_cells(cells, reach, line, cutoff, of_cells, gaps.of[4], apart);
        TerrainBlocks blocks{};
        heights.open_blocks({2 * (k % 6), 4 * (k % 5), 1, false}, from, blocks);
        gaps.near[1] = kernel.of_blocks(blocks, reach, line, cutoff, gaps.of[2], gaps.of[4]);
        BoxPlacement place{{0, 0, float(from.z() - boxes.centre().z())}, false, {}, {}};
        OpenBoxes open;
        boxes.open(ObbTree::root, &place, open);
        gaps.near[2] = kernel.of_boxes(open, reach, line, cutoff, gaps.of[3], gaps.of[4]);
        return gaps;
    };
    for (std::uint32_t k = 0; k < 200; ++k) {
        const Gaps expected = look(baseline::solid_gap_kernel(), k);
        if (instruction_set() >= InstructionSet::avx2) {
            const Gaps got = look(avx2::solid_gap_kernel(), k);
            EXPECT_EQ(std::memcmp(&expected, &got, sizeof got), 0) << k;
        }
        if (instruction_set() >= InstructionSet::avx512) {
            const Gaps got = look(avx512::solid_gap_kernel(), k);
            EXPECT_EQ(std::memcmp(&expected, &got, sizeof got), 0) << k;
        }
    }
}

} // namespace
} // namespace oncollide
