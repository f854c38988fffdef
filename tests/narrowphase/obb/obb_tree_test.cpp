#include <gtest/gtest.h>

#include <oncollide/narrowphase/obb/obb_tree.hpp>
#include <oncollide/samples/generators.hpp>

namespace oncollide::obb_tree_test {
namespace {

/// Grows all nodes.
void grow(ObbTree& tree, ObbTree::Node node = ObbTree::root)
{
    for (unsigned k = 0; k < tree.node(node).lanes; ++k)
        if (!(tree.node(node).leaves >> k & 1)) grow(tree, tree.child(node, k));
}

TEST(ObbTree, IsWithoutFaultWhileItGrows)
{
    for (const std::uint32_t triangles : {1u, 2u, 3u, 9u, 800u}) {
        Mesh mesh = make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 800);
        mesh = make_mesh("part", mesh.vertices, {mesh.triangles.begin(), mesh.triangles.begin() + triangles});
        ObbTree tree(mesh);
        EXPECT_EQ(tree.validate(), "") << "not grown at all";
        tree.grow_in({mesh.bounds.min, mesh.bounds.centre()}, 50);
        EXPECT_EQ(tree.validate(), "") << "grown in part";
        grow(tree);
        EXPECT_EQ(tree.validate(), "");
    }
}

/// Each fault is planted in a whole tree.
TEST(ObbTree, NamesTheFirstFaultOfADamagedTree)
{
    const Mesh mesh = make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 800);
    const auto fault_after = [&](auto damage) {
        ObbTree tree(mesh);
        grow(tree);
        EXPECT_EQ(tree.validate(), "");
        const ObbTree::Node below = tree.child(ObbTree::root, 0);
        damage(const_cast<BoxNode&>(tree.node(below)),
               const_cast<InnerNode&>(reinterpret_cast<const InnerNode&>(tree.node(below))));
        return tree.validate();
    };
    const auto says = [](const std::string& fault, const char* words) {
        EXPECT_NE(fault.find(words), std::string::npos) << fault;
    };
    says(fault_after([](BoxNode& node, InnerNode&) { node.hx[2] /= 2; }), "box 2: does not hold its triangles");
    says(fault_after([](BoxNode& node, InnerNode&) { node.x[0] += 3000; }), "box 0: does not hold its triangles");
    says(fault_after([](BoxNode& node, InnerNode&) { node.leaves ^= 1; }), "does not continue the triangles");
    says(fault_after([](BoxNode& node, InnerNode&) { node.lanes = 9; }), "is not one of eight boxes");
    says(fault_after([](BoxNode&, InnerNode& node) { ++node.begin[3]; }), "box 3: does not continue");
    says(fault_after([](BoxNode&, InnerNode& node) { node.child[1] = 0; }), "nodes are reached");
    says(fault_after([](BoxNode&, InnerNode& node) { node.child[1] = node.child[0]; }), "box 0: does not continue");
}

} // namespace
} // namespace oncollide::obb_tree_test
