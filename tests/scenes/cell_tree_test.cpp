#include <oncollide/scenes/model/map/cell_tree.hpp>

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

namespace oncollide {
namespace {

using Eigen::Vector3i;
using Leaf = std::pair<MapCell, CellState>;

/// The same cells in a flat array.
class Grid {
public:
    static constexpr int low = -13, high = 19;
    CellState& at(const Vector3i& c)
    {
        return cells_[std::size_t((c.x() - low) + n * ((c.y() - low) + n * (c.z() - low)))];
    }
    template <class Visit>
    void each(const CellBox& box, Visit visit)
    {
        for (int z = box.low.z(); z < box.high.z(); ++z)
            for (int y = box.low.y(); y < box.high.y(); ++y)
                for (int x = box.low.x(); x < box.high.x(); ++x) visit(Vector3i(x, y, z));
    }
    static CellBox all() { return {Vector3i::Constant(low), Vector3i::Constant(high)}; }

private:
    static constexpr int n = high - low;
    std::vector<CellState> cells_ = std::vector<CellState>(std::size_t(n) * n * n, CellState::unknown);
};

std::vector<Leaf> leaves_of(const CellTree& tree)
{
    std::vector<Leaf> leaves;
    tree.each_leaf([&](const MapCell& cell, CellState state) { leaves.push_back({cell, state}); });
    return leaves;
}

CellBox drawn_box(std::mt19937_64& random)
{
    const auto draw = [&] { return Grid::low + int(random() % unsigned(Grid::high - Grid::low)); };
    const Vector3i a(draw(), draw(), draw()), b(draw(), draw(), draw());
    if (random() % 2) return {a, a.array() + 1};
    return {a.cwiseMin(b), a.cwiseMax(b).array() + 1};
}

TEST(CellTree, HoldsAfterAnyChangesWhatAListOfCellsHolds)
{
    for (const bool unknown_is_solid : {false, true})
        for (std::uint64_t seed = 0; seed < 30; ++seed) {
            std::mt19937_64 random(seed);
            CellTree tree(unknown_is_solid);
            Grid grid;
            for (int change = 0; change < 40; ++change) {
                const CellBox box = drawn_box(random);
                const auto state = CellState(random() % 3);
                tree.set(box, state);
                grid.each(box, [&](const Vector3i& cell) { grid.at(cell) = state; });
            }
            CellTree fresh(unknown_is_solid);
            CellBox bounds(Vector3i::Constant(1000), Vector3i::Constant(-1000));
            std::size_t solid = 0;
            grid.each(Grid::all(), [&](const Vector3i& cell) {
                const CellState state = grid.at(cell);
                ASSERT_EQ(int(tree.state(cell)), int(state)) << "seed " << seed;
                if (state != CellState::unknown) fresh.set({cell, cell.array() + 1}, state);
                if (state == CellState::unknown || (state == CellState::free && !unknown_is_solid)) return;
                bounds = {bounds.low.cwiseMin(cell), bounds.high.cwiseMax((cell.array() + 1).matrix())};
                solid += state == CellState::occupied;
            });
            EXPECT_EQ(leaves_of(tree), leaves_of(fresh)) << "seed " << seed;
            EXPECT_EQ(tree.count(), fresh.count());
            EXPECT_EQ(tree.top().solid, fresh.top().solid);
            EXPECT_EQ(tree.bounds().low, bounds.low) << "seed " << seed;
            EXPECT_EQ(tree.bounds().high, bounds.high) << "seed " << seed;
            if (unknown_is_solid) continue;
            std::size_t found = 0;
            tree.each_solid(
                [](const MapCell&) { return true; },
                [&](const MapCell& cube) { return found += std::size_t(cube.side) * cube.side * cube.side; });
            EXPECT_EQ(found, solid);
        }
}

TEST(CellTree, TellsWhatWasThereBefore)
{
    std::mt19937_64 random(3);
    CellTree tree;
    for (int change = 0; change < 200; ++change) {
        const CellTree old = tree;
        std::vector<Leaf> before;
        tree.set(drawn_box(random), CellState(random() % 3), &before);
        CellTree back = tree;
        std::ranges::reverse(before);
        for (const auto& [cell, state] : before) back.set(CellBox(cell), state);
        ASSERT_EQ(leaves_of(back), leaves_of(old)) << "change " << change;
    }
}

TEST(CellTree, JoinsOctantsOfOneStateUpToTheGrid)
{
    const CellBox grid(CellTree::top_cube.octant(0));
    CellTree tree;
    tree.set(grid, CellState::free);
    EXPECT_EQ(tree.bytes(), 0u);
    tree.set({Vector3i(5, 6, 7), Vector3i(6, 7, 8)}, CellState::occupied);
    EXPECT_EQ(tree.count(), 1u + 16 * 8);
    EXPECT_EQ(tree.bounds().low, Vector3i(5, 6, 7));
    tree.set({Vector3i(5, 6, 7), Vector3i(6, 7, 8)}, CellState::free);
    EXPECT_EQ(leaves_of(tree), (std::vector<Leaf>{{CellTree::top_cube.octant(0), CellState::free}}));
    tree.set({Vector3i::Constant(-100'000), Vector3i::Constant(100'000)}, CellState::occupied);
    EXPECT_EQ(leaves_of(tree), (std::vector<Leaf>{{CellTree::top_cube.octant(0), CellState::occupied}}));
}

TEST(CellTree, UsesTheRoomOfWhatWentAgain)
{
    std::mt19937_64 random(5);
    CellTree tree;
    std::size_t most = 0;
    for (int round = 0; round < 100; ++round) {
        for (int change = 0; change < 50; ++change) tree.set(drawn_box(random), CellState(random() % 3));
        if (round == 20) most = tree.bytes();
    }
    EXPECT_LE(tree.bytes(), 2 * most);
}

} // namespace
} // namespace oncollide
