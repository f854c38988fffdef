#pragma once
#include <cstdint>
#include <vector>

#include <oncollide/base/cpu_features.hpp>
#include <oncollide/narrowphase/boxes/obb_tree.hpp>
#include <oncollide/narrowphase/boxes/oriented_box_kernel.hpp>

namespace oncollide {

inline const OrientedBoxKernel& oriented_box_kernel()
{
    static const OrientedBoxKernel kernel = ONCOLLIDE_CHOOSE(oriented_box_kernel);
    return kernel;
}

/// The nodes of one tree that a query has opened, in A's frame, each once.
class OpenedTree {
public:
    struct Node {
        OpenBoxes boxes;
        const BoxNode* node;
        std::uint32_t index, leaves, singles;

        bool leaf(unsigned k) const { return leaves >> k & 1; }
        bool single(unsigned k) const { return singles >> k & 1; }
        float size(unsigned k) const { return boxes.size[k]; }
    };

    /// Starts a query: slot 0 is the root. Keeps both.
    void start(ObbTree& tree, const BoxPlacement* placement)
    {
        tree_ = &tree, placement_ = placement;
        used_ = 0;
        ++query_;
        open(ObbTree::root);
    }
    const Node& operator[](std::uint32_t slot) const { return nodes_[slot]; }
    const ObbTree& tree() const { return *tree_; }

    /// The slot of the node below box `k`. References to nodes end here.
    std::uint32_t descend(std::uint32_t slot, unsigned k)
    {
        const std::uint32_t index = tree_->child(nodes_[slot].index, k);
        return index < slots_.size() && slots_[index].query == query_ ? slots_[index].slot : open(index);
    }

private:
    struct Slot {
        std::uint64_t query = 0;
        std::uint32_t slot = 0;
    };

    std::uint32_t open(std::uint32_t index)
    {
        if (index >= slots_.size()) slots_.resize(2 * std::size_t(index) + 64);
        if (used_ == nodes_.size()) nodes_.resize(2 * std::size_t(used_) + 16);
        slots_[index] = {query_, used_};
        Node& open = nodes_[used_];
        open.node = &tree_->node(index), open.index = index, open.leaves = open.node->leaves,
        open.singles = open.node->singles;
        oriented_box_kernel().open(*open.node, placement_, open.boxes);
        return used_++;
    }

    ObbTree* tree_ = nullptr;
    const BoxPlacement* placement_ = nullptr;
    std::vector<Node> nodes_; ///< by slot
    std::uint32_t used_ = 0;
    std::vector<Slot> slots_; ///< by node
    std::uint64_t query_ = 0;
};

} // namespace oncollide
