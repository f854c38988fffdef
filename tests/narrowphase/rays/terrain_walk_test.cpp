// Segments over terrains: the walk through blocks, compared with tests of all triangles.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/base/simd/cpu_features.hpp>
#include <oncollide/narrowphase/rays/segment_tests.hpp>
#include <oncollide/narrowphase/rays/terrain_walk.hpp>
#include <oncollide/scenes/model/terrain.hpp>

namespace oncollide::terrain_walk_test {
namespace {

using Eigen::Vector3d;

struct Ground {
    std::uint32_t columns, rows;
    double steepness, holes;
    Vector3d origin;
    Eigen::Vector2d spacing;
    int bytes;
};

/// Random slopes with steps; integers, so that segments can meet corners and edges exactly.
Terrain make(const Ground& g, std::uint64_t seed)
{
    TerrainGrid grid;
    grid.columns = g.columns, grid.rows = g.rows, grid.spacing = g.spacing, grid.origin = g.origin,
    grid.bytes = g.bytes;
    grid.no_data = -9999;
    std::vector<double> heights;
    for (std::uint32_t j = 0; j < g.rows; ++j)
        for (std::uint32_t i = 0; i < g.columns; ++i) {
            const double rolling = 3 * std::sin(0.3 * i) + 2 * std::cos(0.2 * j), rough = 4 * u01(seed, i, j);
            const bool hole = g.columns > 2 && u01(seed + 1, i, j) < g.holes;
            heights.push_back(hole ? -9999 : std::floor(g.steepness * (rolling + rough)));
        }
    for (std::uint32_t k = 0; k < (g.columns - 1) * (g.rows - 1); ++k) grid.falling.push_back(u01(seed, k, 7) < 0.5);
    return make_terrain("ground", grid, heights);
}

/// Segments of many kinds: from top to bottom, also at corners and along grid lines; along edges and diagonals; short;
/// long; points; in the air.
Segment segment_over(const Terrain& t, std::uint64_t seed)
{
    const auto in = [&](std::uint64_t k) -> Vector3d {
        const Vector3d share(u01(seed, k, 1), u01(seed, k, 2), u01(seed, k, 3));
        return t.bounds().min + (1.4 * share.array() - 0.2).matrix().cwiseProduct(t.bounds().max - t.bounds().min);
    };
    const auto corner = [&](std::uint64_t k) -> Vector3d {
        const auto c = static_cast<std::uint32_t>(u01(seed, k, 4) * t.columns()),
                   r = static_cast<std::uint32_t>(u01(seed, k, 5) * t.rows());
        const double z = t.height(c, r);
        return {t.x(c), t.y(r), std::isnan(z) ? t.bounds().centre().z() : t.origin().z() + z};
    };
    const double size = t.bounds().diagonal();
    const auto upright = [&](const Vector3d& p) {
        return Segment{{p.x(), p.y(), t.bounds().max.z() + 1}, {p.x(), p.y(), t.bounds().min.z() - 1}};
    };
    switch (seed % 8) {
    case 0:
        return upright(in(0));
    case 1:
        return upright(corner(0));
    case 2:
        return {corner(0), corner(1)};
    case 3: { // along an edge or a diagonal, or beside one
        const Vector3d p = corner(0), q = p + Vector3d(t.spacing().x(), (seed / 8 % 2 ? 1 : 0) * t.spacing().y(), 0);
        return {p, q};
    }
    case 4:
        return {in(0), in(0) + 0.01 * size * (in(1) - in(2)).normalized()};
    case 5:
        return {in(0), in(1)};
    case 6:
        return {corner(0), corner(0)};
    default:
        return {in(0) + Vector3d(0, 0, 1e3 * size), in(1) - Vector3d(0, 0, 1e3 * size)};
    }
}

bool has_cell(const Terrain& t, std::uint32_t number)
{
    const std::uint32_t x = number % t.cells_x(), y = number / t.cells_x();
    return !std::isnan(t.height(x, y) + t.height(x + 1, y) + t.height(x, y + 1) + t.height(x + 1, y + 1));
}

const Ground grounds[] = {
    {2, 2, 1, 0, {0, 0, 0}, {1, 1}, 8},          {3, 2, 1, 0, {0, 0, 0}, {1, 1}, 8},
    {6, 4, 1, 0.1, {5, -3, 2}, {0.5, 2}, 2},     {9, 9, 5, 0, {0, 0, 0}, {1, 1}, 8},
    {18, 11, 1, 0.2, {-7, 3, 0}, {1, 1}, 4},     {40, 70, 50, 0.02, {0, 0, 0}, {1, 1}, 8},
    {90, 34, 0, 0, {0, 0, 0}, {1, 1}, 8}, // flat
    {70, 70, 1, 0, {1e6, -2e6, 3e5}, {1, 1}, 8}, {70, 70, 1, 0.05, {0, 0, 0}, {0.001, 1000}, 8},
    {130, 67, 0.001, 0, {0, 0, 0}, {30, 30}, 8},
};

TEST(TerrainWalk, TakesEveryTriangleThatTheSegmentMeets)
{
    int meetings = 0, certain_ones = 0, taken_ones = 0;
    for (const Ground& ground : grounds) {
        // All triangles are in one plane, or rounding hides how the line passes slivers.
        const bool counts = ground.steepness > 0 && ground.spacing.y() < 10 * ground.spacing.x();
        const Terrain terrain = make(ground, 11);
        const TerrainTree tree(terrain);
        SegmentWalk<TerrainTree> walk;
        for (std::uint64_t seed = 0; seed < 400; ++seed) {
            SCOPED_TRACE(fmt::format("{} x {}, seed {}", ground.columns, ground.rows, seed));
            const Segment segment = segment_over(terrain, seed);
            std::set<std::uint32_t> taken, certain;
            walk.walk(tree, segment, [&](std::uint32_t triangle, bool across) {
                EXPECT_TRUE(taken.insert(triangle).second) << "twice: " << triangle;
                if (across) certain.insert(triangle);
                return 1.0;
            });
            for (std::uint32_t t = 0; t < 2 * terrain.cells(); ++t) {
                const TrianglePoints points = tree.points(t);
                const bool meets = has_cell(terrain, t / 2) && segment_meets(segment, points);
                EXPECT_TRUE(!meets || taken.contains(t)) << "lost: " << t;
                EXPECT_TRUE(meets || !certain.contains(t)) << "invented: " << t;
                meetings += meets && counts;
            }
            if (!counts) continue;
            taken_ones += static_cast<int>(taken.size()), certain_ones += static_cast<int>(certain.size());
        }
    }
    EXPECT_GT(meetings, 4000);
    EXPECT_GT(certain_ones, meetings / 12); // many segments meet corners and edges
    EXPECT_LT(taken_ones, 3 * meetings);
}

TEST(TerrainWalk, StopsAtTheReachThatItIsGiven)
{
    const Terrain terrain = make(grounds[5], 3);
    const TerrainTree tree(terrain);
    SegmentWalk<TerrainTree> walk;
    for (std::uint64_t seed = 5; seed < 800; seed += 8) {
        const Segment segment = segment_over(terrain, seed);
        int calls = 0;
        walk.walk(tree, segment, [&](std::uint32_t) { return ++calls, -1.0; });
        EXPECT_LE(calls, 1);
        int all = 0, before = 0;
        walk.walk(tree, segment, [&](std::uint32_t) { return ++all, 1.0; });
        walk.walk(
            tree, segment, [&](std::uint32_t) { return ++before, 0.25; }, 0.25);
        EXPECT_LE(before, all);
        EXPECT_EQ(calls, std::min(all, 1));
    }
}

TEST(TerrainWalk, KernelsAreAlikeOnEveryInstructionSet)
{
    if (instruction_set() < InstructionSet::avx2) GTEST_SKIP() << "no AVX2";
    const TerrainRayKernel one = baseline::terrain_ray_kernel(), two = avx2::terrain_ray_kernel();
    unsigned met = 0;
    for (const Ground& ground : grounds) {
        const Terrain terrain = make(ground, 5);
        const TerrainTree tree(terrain);
        for (std::uint64_t seed = 0; seed < 100; ++seed) {
            const auto cell = [&](std::uint64_t k, std::uint32_t cells) {
                return static_cast<std::uint32_t>(u01(seed, 3, k) * cells);
            };
            const Vector3d from = segment_over(terrain, seed).from;
            const float direction[3] = {0.6f, -0.48f, -0.64f};
            TerrainCells cells;
            tree.open_cells({cell(0, terrain.cells_x()), cell(1, terrain.cells_y()), 0, false}, from, cells);
            const CellHits x = one.cells(cells, direction, 1e-6f), y = two.cells(cells, direction, 1e-6f);
            EXPECT_EQ(std::memcmp(&x, &y, sizeof x), 0);
            const TerrainTree::Node top = tree.child(TerrainTree::root, 0);
            if (top.level == 0) continue;
            TerrainBlocks blocks;
            tree.open_blocks(top, tree.centre(), blocks);
            TerrainLine line{{{}, {}, {}}, {}, 1e-3f};
            for (int i = 0; i < 3; ++i) {
                const auto at = static_cast<float>(from[i] - tree.centre()[i]);
                line.ray.inverse[i] = 1 / direction[i], line.direction[i] = direction[i];
                line.ray.from_less[i] = at - 1e-3f, line.ray.from_more[i] = at + 1e-3f;
            }
            float entry_one[8], entry_two[8];
            const unsigned of_one = one.blocks(blocks, line, 1e4f, entry_one);
            EXPECT_EQ(two.blocks(blocks, line, 1e4f, entry_two), of_one);
            EXPECT_EQ(std::memcmp(entry_one, entry_two, sizeof entry_one), 0);
            met += of_one;
        }
    }
    EXPECT_GT(met, 0u);
}

} // namespace
} // namespace oncollide::terrain_walk_test
