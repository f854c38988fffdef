#include <cmath>

#include <gtest/gtest.h>

#include <oncollide/narrowphase/walks/open_nodes.hpp>

namespace oncollide::open_nodes_test {
namespace {

/// 512 unit cubes in a row, in a tree of eight boxes per node. Counts how often each node is opened.
struct Row {
    struct Node {
        std::uint32_t first, count; ///< cubes of the node; its eight boxes hold an eighth each
        bool whole;                 ///< true: one box around all
    };
    using Primitive = std::uint32_t;
    static constexpr Node root{0, 512, true};

    Eigen::Vector3d centre() const { return {256, 0.5, 0.5}; }
    double radius() const { return 257; }
    LaneMasks open(const Node& node, const BoxPlacement* placement, OpenBoxes& boxes) const
    {
        ++opened;
        EXPECT_EQ(placement, expected);
        boxes = {};
        const std::uint32_t lanes = node.whole ? 1 : 8, each = node.count / lanes;
        for (std::uint32_t k = 0; k < lanes; ++k)
            boxes.c[0][k] = float(node.first + k * each) + 0.5f * float(each), boxes.size[k] = float(each * each);
        const std::uint32_t all = (1u << lanes) - 1;
        return each == 1 ? LaneMasks{all, all} : LaneMasks{0, 0};
    }
    Node child(const Node& node, unsigned k)
    {
        if (node.whole) return {node.first, node.count, false};
        return {node.first + k * (node.count / 8), node.count / 8, false};
    }
    std::array<Primitive, 1> primitives(const Node& node, unsigned k) const { return {node.first + k}; }

    mutable int opened = 0;
    const BoxPlacement* expected = nullptr;
};
static_assert(BoxHierarchy<Row>);

class OpenNodesOfARow : public testing::Test {
protected:
    OpenNodesOfARow()
    {
        nodes.start(row, nullptr);
        root = nodes.open(Row::root);
    }

    Row row;
    OpenNodes<Row> nodes;
    std::uint32_t root;
};

TEST_F(OpenNodesOfARow, OpenEachNodeOnceHoweverOftenItIsReached)
{
    const std::uint32_t all = nodes.descend(root, 0), fourth = nodes.descend(all, 4), leaf = nodes.descend(fourth, 7);
    EXPECT_EQ(row.opened, 4);
    EXPECT_EQ(nodes.descend(root, 0), all);
    EXPECT_EQ(nodes.descend(all, 4), fourth);
    EXPECT_EQ(nodes.descend(fourth, 7), leaf);
    EXPECT_EQ(row.opened, 4);
    EXPECT_NE(nodes.descend(all, 5), fourth);
    EXPECT_EQ(row.opened, 5);
    EXPECT_EQ(nodes[fourth].node.first, 4u * 64);
    EXPECT_EQ(nodes[leaf].node.first, 4u * 64 + 7 * 8);
}

TEST_F(OpenNodesOfARow, KnowTheLeavesAndTheirPrimitives)
{
    const std::uint32_t all = nodes.descend(root, 0), third = nodes.descend(all, 3), leaf = nodes.descend(third, 2);
    EXPECT_FALSE(nodes[third].leaf(2));
    for (unsigned k = 0; k < 8; ++k) {
        EXPECT_TRUE(nodes[leaf].leaf(k) && nodes[leaf].single(k));
        EXPECT_EQ(nodes.primitives(leaf, k)[0], 3u * 64 + 2 * 8 + k);
        EXPECT_EQ(nodes[leaf].boxes.c[0][k], float(3 * 64 + 2 * 8 + k) + 0.5f);
    }
}

TEST_F(OpenNodesOfARow, ClimbToTheBoxesAboveAsFarAsNodesAreOpen)
{
    const std::uint32_t all = nodes.descend(root, 0), sixth = nodes.descend(all, 6), leaf = nodes.descend(sixth, 1);
    using Place = std::pair<std::uint32_t, std::uint8_t>;
    EXPECT_EQ(nodes.up(leaf, 5, 0), Place(leaf, 5));
    EXPECT_EQ(nodes.up(leaf, 5, 1), Place(sixth, 1));
    EXPECT_EQ(nodes.up(leaf, 5, 2), Place(all, 6));
    EXPECT_EQ(nodes.up(leaf, 5, 99), Place(root, 0));
    const std::uint32_t alone = nodes.open({64, 64, false}); // an entry in the middle of the tree
    EXPECT_EQ(nodes.up(alone, 3, 2), Place(alone, 3));
}

TEST_F(OpenNodesOfARow, KeepWhatTheyOpenedWhileTheirMemoryGrows)
{
    const std::uint32_t all = nodes.descend(root, 0);
    std::vector<std::uint32_t> slots;
    for (unsigned j = 0; j < 8; ++j)
        for (unsigned k = 0; k < 8; ++k) slots.push_back(nodes.descend(nodes.descend(all, j), k));
    EXPECT_EQ(row.opened, 2 + 8 + 64);
    for (unsigned i = 0; i < 64; ++i) {
        EXPECT_EQ(nodes[slots[i]].node.first, i * 8);
        EXPECT_EQ(nodes[slots[i]].lane, i % 8);
    }
}

TEST_F(OpenNodesOfARow, BeginANewQueryWithoutOpenNodes)
{
    nodes.descend(nodes.descend(root, 0), 4);
    BoxPlacement placement{};
    Row other;
    other.expected = &placement;
    nodes.start(other, &placement);
    EXPECT_EQ(nodes.open(Row::root), 0u);
    nodes.descend(nodes.descend(0, 0), 4);
    EXPECT_EQ(other.opened, 3);
    EXPECT_EQ(row.opened, 3);
}

} // namespace
} // namespace oncollide::open_nodes_test
