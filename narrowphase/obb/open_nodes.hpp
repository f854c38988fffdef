#pragma once
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include <oncollide/narrowphase/obb/hierarchy.hpp>

namespace oncollide {

/// The nodes of one hierarchy that a query has opened, in A's frame, each once. One thread's working memory.
template <BoxHierarchy Hierarchy>
class OpenNodes {
public:
    struct Node {
        OpenBoxes boxes;
        typename Hierarchy::Node node;
        LaneMasks masks;
        std::array<std::uint32_t, 8> below; ///< slot of the node below box k; 0: not open
        std::uint32_t above;                ///< slot of the node that it was reached from; its own: none
        std::uint8_t lane;                  ///< box of that node that it is below

        bool leaf(unsigned k) const { return masks.leaves >> k & 1; }
        bool single(unsigned k) const { return masks.singles >> k & 1; }
        float size(unsigned k) const { return boxes.size[k]; }
    };

    /// Starts a query of which nothing is open. Keeps both.
    void start(Hierarchy& hierarchy, const BoxPlacement* placement)
    {
        hierarchy_ = &hierarchy, placement_ = placement;
        used_ = 0;
    }
    /// Opens a node that is not below another open one; the first, in slot 0, is never below one. Returns its slot.
    std::uint32_t open(const typename Hierarchy::Node& node)
    {
        if (used_ == nodes_.size()) nodes_.resize(2 * std::size_t(used_) + 16);
        Node& open = nodes_[used_];
        open.node = node, open.below = {}, open.above = used_;
        open.masks = hierarchy_->open(node, placement_, open.boxes);
        return used_++;
    }
    const Node& operator[](std::uint32_t slot) const { return nodes_[slot]; }

    /// The slot of the node below box `k`. References to nodes end here.
    std::uint32_t descend(std::uint32_t slot, unsigned k)
    {
        if (const std::uint32_t below = nodes_[slot].below[k]) return below;
        const std::uint32_t below = open(hierarchy_->child(nodes_[slot].node, k));
        nodes_[below].above = slot, nodes_[below].lane = static_cast<std::uint8_t>(k);
        return nodes_[slot].below[k] = below;
    }
    /// Begins to load the node below box `k`, where it is stored and not open.
    void prefetch(std::uint32_t slot, unsigned k) const
    {
        if constexpr (requires(Hierarchy & h, typename Hierarchy::Node n) { h.prefetch_child(n, k); })
            if (const Node& above = nodes_[slot]; !above.below[k] && !above.leaf(k))
                hierarchy_->prefetch_child(above.node, k);
    }
    /// The same of these boxes, a bit each, in a hierarchy that is mostly in no cache.
    void prefetch_below(std::uint32_t slot, unsigned boxes) const
    {
        if constexpr (requires { hierarchy_->is_large(); })
            if (hierarchy_->is_large())
                for (boxes &= ~nodes_[slot].masks.leaves; boxes; boxes &= boxes - 1)
                    hierarchy_->prefetch_child(nodes_[slot].node, static_cast<unsigned>(__builtin_ctz(boxes)));
    }
    /// The box `levels` up from box `k`, or as far up as nodes are open.
    std::pair<std::uint32_t, std::uint8_t> up(std::uint32_t slot, std::uint8_t k, int levels) const
    {
        for (; levels > 0 && nodes_[slot].above != slot; --levels) k = nodes_[slot].lane, slot = nodes_[slot].above;
        return {slot, k};
    }
    auto primitives(std::uint32_t slot, unsigned k) const { return hierarchy_->primitives(nodes_[slot].node, k); }

private:
    Hierarchy* hierarchy_ = nullptr;
    const BoxPlacement* placement_ = nullptr;
    std::vector<Node> nodes_; ///< by slot
    std::uint32_t used_ = 0;
};

} // namespace oncollide
