#include <cstring>
#include <vector>

#include <gtest/gtest.h>

#include <oncollide/narrowphase/obb/obb_tree.hpp>
#include <oncollide/samples/generators.hpp>

namespace oncollide {
namespace {

/// A copy that follows a tree.
struct Copy {
    std::vector<NodeLine> lines;
    std::vector<std::uint32_t> order;

    void follow(const ObbTree& tree)
    {
        TreeGrowth growth;
        tree.copy_growth(static_cast<std::uint32_t>(lines.size()), growth);
        lines.insert(lines.end(), growth.added.begin(), growth.added.end());
        for (std::size_t i = 0; i < growth.changed.size(); ++i) lines[growth.changed[i]] = growth.contents[i];
        order.resize(tree.mesh().triangles.size());
        std::size_t from = 0;
        for (const TreeGrowth::Range& range : growth.sorted)
            for (std::uint32_t i = 0; i < range.count; ++i) order[range.begin + i] = growth.order[from++];
    }
    const InnerNode& node(std::uint32_t index) const { return reinterpret_cast<const InnerNode&>(lines[index]); }
};

/// Expects the nodes that the tree has, and no others; adds boxes that are not grown.
void expect_equal(const ObbTree& tree, const Copy& copy, ObbTree::Node index,
                  std::vector<std::pair<ObbTree::Node, unsigned>>& open)
{
    const BoxNode& node = tree.node(index);
    ASSERT_EQ(std::memcmp(&copy.lines[index], &node, sizeof(BoxNode)), 0) << index;
    for (unsigned k = 0; k < node.lanes; ++k) {
        if (node.leaves >> k & 1) continue;
        const std::uint32_t child = copy.node(index).child[k];
        ASSERT_EQ(child != 0, tree.is_grown(index, k)) << index;
        ASSERT_EQ(copy.node(index).begin[k], tree.begin_of(index, k));
        if (child)
            expect_equal(tree, copy, child, open);
        else
            open.emplace_back(index, k);
    }
}

TEST(TreeGrowth, KeepsACopyEqual)
{
    const Mesh mesh = make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 1500);
    ObbTree tree(mesh);
    Copy copy;
    for (std::size_t step = 0;; ++step) {
        copy.follow(tree);
        std::vector<std::pair<ObbTree::Node, unsigned>> open;
        expect_equal(tree, copy, ObbTree::root, open);
        for (std::uint32_t place = 0; place < mesh.triangles.size() && tree.nodes() > 1; ++place)
            ASSERT_EQ(copy.order[place], tree.triangle(place)) << step;
        if (open.empty()) break;
        for (std::size_t i = 0; i < 3; ++i) { // some of them, also in a row
            const auto& [node, box] = open[(7 * step + i) % open.size()];
            tree.child(node, box);
        }
    }
    EXPECT_EQ(copy.lines.size(), tree.lines());
    EXPECT_GT(tree.nodes(), 200u);
}

} // namespace
} // namespace oncollide
