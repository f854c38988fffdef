#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include <oncollide/narrowphase/spheres/ocst.hpp>
#include <oncollide/samples/generators.hpp>

#include "narrowphase/geometry_surface.hpp"

namespace oncollide {
namespace {

TEST(CellKey, NamesLevelOctantAndPlace)
{
    CellKey cell = root_cell;
    EXPECT_EQ(level_of(cell), 0);
    for (unsigned octant : {5u, 0u, 7u}) cell = child_cell(cell, octant);
    EXPECT_EQ(level_of(cell), 3);
    EXPECT_EQ(octant_at(cell, 0), 5u);
    EXPECT_EQ(octant_at(cell, 1), 0u);
    EXPECT_EQ(octant_of(cell), 7u);
    EXPECT_EQ(level_of(parent_cell(cell)), 2);
    // x: high, low, high = +4 -2 +1; y: low, low, high; z: high, low, high
    EXPECT_EQ(centre_of(cell), (std::array<std::int32_t, 3>{3, -5, 3}));
}

TEST(CellKey, ItsCentreIsTheSumOfItsSteps)
{
    std::mt19937 random(7);
    for (int depth = 0; depth <= deepest_level; ++depth)
        for (int i = 0; i < 50; ++i) {
            CellKey cell = root_cell;
            std::array<std::int32_t, 3> at{};
            for (int level = 0; level < depth; ++level) {
                const unsigned octant = i == 0 ? 0 : i == 1 ? 7 : random() % 8;
                cell = child_cell(cell, octant);
                for (std::size_t axis = 0; axis < 3; ++axis) at[axis] = 2 * at[axis] + (octant >> axis & 1 ? 1 : -1);
            }
            EXPECT_EQ(centre_of(cell), at) << cell;
        }
}

class OcstTest : public ::testing::Test {
protected:
    OcstTest() : geometry_{"knot", make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 800), {}}
    {
        backend_->attach(0, make_surface(geometry_, root_cell_of(geometry_)));
    }
    void expand(Ocst& tree, CellKey cell, std::uint32_t frame)
    {
        const OctantRow row = tree.row(0, cell);
        OctantResult answer;
        backend_->run({&row, 1}, 1, {&answer, 1});
        tree.expand(cell, answer, frame);
    }
    /// The root's first grey octant.
    static CellKey first_grey(const Ocst& tree)
    {
        return child_cell(root_cell, static_cast<unsigned>(std::countr_zero(tree.nodes()[0].grey())));
    }

    Geometry geometry_;
    std::unique_ptr<OcclusionBackend> backend_ = make_cpu_backend();
};

TEST_F(OcstTest, StoresNothingButTheRootUntilAsked)
{
    const Ocst tree(root_cell_of(geometry_), 6, 0);
    EXPECT_EQ(tree.size(), 1u);
    EXPECT_FALSE(tree.nodes()[0].expanded());
    EXPECT_DOUBLE_EQ(tree.radius(3), tree.radius(0) / 8);
}

TEST_F(OcstTest, HoldsTheGeometryInItsRootAndPlacesPoints)
{
    const Ocst tree(root_cell_of(geometry_), 4, 0);
    for (const Eigen::Vector3d& v : std::get<Mesh>(geometry_.data).vertices) {
        const CellKey cell = tree.cell_at(v, 4);
        const auto at = centre_of(cell);
        for (int axis = 0; axis < 3; ++axis) {
            const double half = std::ldexp(double(tree.root().half[axis]), -4);
            EXPECT_LE(std::abs(v[axis] - tree.root().centre[axis] - at[axis] * half), half * (1 + 1e-9));
        }
    }
}

TEST_F(OcstTest, DropsWhatAgedAndRegrowsTheSame)
{
    Ocst tree(root_cell_of(geometry_), 5, 0);
    expand(tree, root_cell, 10);
    const CellKey child = first_grey(tree);
    expand(tree, child, 10);
    const CellKey other = child_cell(root_cell, static_cast<unsigned>(std::bit_width(tree.nodes()[0].grey()) - 1));
    ASSERT_NE(child, other);
    expand(tree, other, 20);
    const std::uint64_t full = tree.size();
    const std::size_t bytes = backend_->bytes();

    // Time of last use: 20 for the root and one child, 10 for the other child.
    tree.nodes()[0].state = (tree.nodes()[0].state & 0x1ff) | 20u << OcstNode::stamp_shift;
    const std::uint64_t dropped = tree.collapse(24, 5, 0, *backend_);
    EXPECT_EQ(dropped, full - tree.size());
    EXPECT_GT(dropped, 0u);
    EXPECT_TRUE(tree.nodes()[0].expanded());
    EXPECT_FALSE(tree.knows(child_cell(child, 0)) || tree.knows(child_cell(child, 7)));

    expand(tree, child, 24);
    EXPECT_EQ(tree.size(), full) << "the parent's list still exists, so the child is restored unchanged";

    tree.collapse(100, 5, 0, *backend_);
    EXPECT_EQ(tree.size(), 1u) << "an idle tree is its root alone";
    EXPECT_LE(tree.bytes(), 64u);
    expand(tree, root_cell, 101);
    expand(tree, child, 101), expand(tree, other, 101);
    EXPECT_EQ(tree.size(), full);
    EXPECT_LE(backend_->bytes(), 2 * bytes) << "released lists are used again";
}

TEST_F(OcstTest, EveryLiveCellIsVisitedOnceLeavesIncluded)
{
    Ocst tree(root_cell_of(geometry_), 2, 0);
    expand(tree, root_cell, 1);
    const CellKey child = first_grey(tree);
    expand(tree, child, 1);
    std::vector<CellKey> cells;
    std::uint64_t leaves = 0;
    tree.for_each_cell([&](CellKey cell, bool expanded) {
        EXPECT_EQ(expanded, cell == root_cell || cell == child);
        EXPECT_EQ(tree.cell_at(tree.centre(cell), level_of(cell)), cell);
        EXPECT_TRUE(cell == root_cell || tree.knows(cell));
        leaves += level_of(cell) == tree.depth();
        cells.push_back(cell);
    });
    EXPECT_EQ(cells.size(), tree.size() + leaves);
    EXPECT_GT(leaves, 0u);
    std::sort(cells.begin(), cells.end());
    EXPECT_EQ(std::unique(cells.begin(), cells.end()), cells.end());
}

TEST_F(OcstTest, LeavesAreNotStored)
{
    Ocst tree(root_cell_of(geometry_), 1, 0);
    expand(tree, root_cell, 1);
    EXPECT_EQ(tree.size(), 1u);
    EXPECT_NE(tree.nodes()[0].grey(), 0u);
}

/// Each fault is planted in a whole tree.
TEST_F(OcstTest, NamesTheFirstFaultOfADamagedTree)
{
    Ocst tree(root_cell_of(geometry_), 4, 0);
    const auto grow = [&] {
        tree = Ocst(root_cell_of(geometry_), 4, 0);
        expand(tree, root_cell, 0);
        expand(tree, first_grey(tree), 0);
        EXPECT_EQ(tree.validate(), "");
    };
    grow();
    EXPECT_GT(tree.collapse(5, 3, 0, *backend_), 0u);
    EXPECT_EQ(tree.validate(), "") << "dropped cells are free";
    grow();
    ++tree.nodes()[0].first_child;
    EXPECT_NE(tree.validate(), "") << "an expanded cell is not reached";
    grow();
    tree.nodes()[0].first_child = 0;
    EXPECT_EQ(tree.validate(), "cell 0: its children are shared or out of range");
    grow();
    tree.nodes()[1] = {};
    EXPECT_NE(tree.validate(), "") << "its children are lost";
    grow();
    tree.nodes()[2].state = 1;
    EXPECT_EQ(tree.validate(), "cell 2 has children, but is not expanded");
}

} // namespace
} // namespace oncollide
