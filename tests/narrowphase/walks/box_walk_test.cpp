// Traversal of box hierarchies that are not meshes, against brute force.
#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include <oncollide/narrowphase/walks/box_walk_distance.hpp>
#include <oncollide/samples/generators.hpp>

#include "narrowphase/voxel_grid.hpp"
#include "random_pose.hpp"

namespace oncollide {
namespace {

using Eigen::Isometry3d;

static_assert(BoxHierarchy<VoxelGrid>);
static_assert(LeafTests<CubeTests<true>, VoxelGrid, ObbTree>);
static_assert(LeafTests<CubeTests<false>, ObbTree, VoxelGrid>);

/// A hollow sphere of cubes.
VoxelGrid shell()
{
    return VoxelGrid(8, 0.2, [](int x, int y, int z) {
        const int d = (2 * x - 7) * (2 * x - 7) + (2 * y - 7) * (2 * y - 7) + (2 * z - 7) * (2 * z - 7);
        return d < 50 && d > 20;
    });
}

template <bool cubes_first>
void compare_with_brute_force()
{
    using Tests = CubeTests<cubes_first>;
    using Pair = typename Tests::Pair;
    using A = typename Tests::A;
    using B = typename Tests::B;
    const Mesh knot = make_torus_knot_mesh(2, 3, 0.5, 0.2, 0.08, 200);
    VoxelGrid grid = shell();
    ObbTree tree(knot);
    A& a = [&]() -> A& {
        if constexpr (cubes_first)
            return grid;
        else
            return tree;
    }();
    B& b = [&]() -> B& {
        if constexpr (cubes_first)
            return tree;
        else
            return grid;
    }();
    BoxWalk<A, B, Tests> walk;
    int meeting = 0, apart = 0;
    std::uint64_t tested = 0, all = 0;
    for (std::uint64_t seed = 0; seed < 24; ++seed) {
        const Isometry3d of_mesh = Eigen::Translation3d(0.8, 0.8, 0.8) * random_pose(seed, 1.8);
        const Isometry3d stay = Isometry3d::Identity();
        const RelativePose b_to_a = cubes_first ? RelativePose(stay, of_mesh) : RelativePose(of_mesh, stay);

        Tests truth;
        truth.start(a, b, b_to_a);
        std::vector<Pair> pairs;
        double distance = std::numeric_limits<double>::infinity();
        for (const std::uint32_t cube : grid.cubes())
            for (std::uint32_t t = 0; t < knot.triangles.size(); ++t) {
                const Pair pair = cubes_first ? Pair{cube, t} : Pair{t, cube};
                if (truth.meet(pair))
                    pairs.push_back(pair), distance = 0;
                else if (distance > 0)
                    distance = std::min(distance, truth.nearest(pair, 0x1p-40).distance);
            }
        std::sort(pairs.begin(), pairs.end());
        (pairs.empty() ? apart : meeting) += 1;

        std::vector<Pair> found;
        walk.leaves().tested = 0;
        const double bound = walk.meetings(
            a, b, b_to_a, {},
            [&](Pair pair) {
                found.push_back(pair);
                return true;
            },
            [](Pair) { return false; });
        std::sort(found.begin(), found.end());
        EXPECT_EQ(found, pairs) << seed;
        EXPECT_LE(bound, distance) << seed;
        EXPECT_EQ(bound > 0, pairs.empty()) << seed;
        tested += walk.leaves().tested, all += grid.cubes().size() * knot.triangles.size();

        const auto bounds = walk.distance(a, b, b_to_a, 0, std::numeric_limits<double>::infinity());
        EXPECT_LE(bounds.lower, distance) << seed;
        EXPECT_GE(bounds.upper, distance) << seed;
        EXPECT_LE(bounds.upper - bounds.lower, 1e-9) << seed;
        for (const double clearance : {0.0, 0.05, 0.3}) {
            const auto near = walk.near(a, b, b_to_a, clearance, 0.01, {});
            if (distance <= clearance) {
                EXPECT_TRUE(near.near) << seed;
            }
            EXPECT_TRUE(near.near ? distance <= near.bound : near.bound <= distance) << seed;
            EXPECT_LE(near.near ? near.bound : clearance, clearance + 0.011);
        }
    }
    EXPECT_GT(meeting, 5);
    EXPECT_GT(apart, 5);
    EXPECT_LT(tested, all / 30) << "boxes part most";
}

TEST(BoxWalk, TakesAGridOfCubesAgainstAMeshByAnOpenerAndLeafTestsAlone)
{
    compare_with_brute_force<true>();
}

TEST(BoxWalk, TakesAMeshAgainstAGridOfCubesByAnOpenerAndLeafTestsAlone)
{
    compare_with_brute_force<false>();
}

} // namespace
} // namespace oncollide
