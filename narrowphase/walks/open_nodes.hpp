#pragma once
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include <oncollide/narrowphase/obb/hierarchy.hpp>

namespace oncollide {

/// The nodes of one hierarchy that a query has opened, each once, in A's frame. One thread's working memory.
template <BoxHierarchy Hierarchy>
class OpenNodes {
public:
    struct Node {
        OpenBoxes boxes;
        typename Hierarchy::Node node;
        LaneMasks masks;
        std::array<std::uint32_t, 8> below; ///< slot of the child node of box k; 0: not open
        std::uint32_t above;                ///< slot of the parent node; its own slot: it has none
        std::uint8_t lane;                  ///< box of the parent node that contains this node

        bool leaf(unsigned k) const { return masks.leaves >> k & 1; }
        bool single(unsigned k) const { return masks.singles >> k & 1; }
        float size(unsigned k) const { return boxes.size[k]; }
    };

    /// Starts a query with no open nodes. Keeps references to both.
    void start(Hierarchy& hierarchy, const BoxPlacement* placement)
    {
        hierarchy_ = &hierarchy, placement_ = placement;
        used_ = 0;
    }
    /// Opens a node that is not the child of an open node, such as the first one, in slot 0. Returns its slot.
    std::uint32_t open(const typename Hierarchy::Node& node)
    {
        if (used_ == nodes_.size()) nodes_.resize(2 * std::size_t(used_) + 16);
        Node& open = nodes_[used_];
        open.node = node, open.below = {}, open.above = used_;
        open.masks = hierarchy_->open(node, placement_, open.boxes);
        return used_++;
    }
    const Node& operator[](std::uint32_t slot) const { return nodes_[slot]; }

    /// The slot of the child node of box `k`, opened if needed. Invalidates references to nodes.
    std::uint32_t descend(std::uint32_t slot, unsigned k)
    {
        if (const std::uint32_t below = nodes_[slot].below[k]) return below;
        const std::uint32_t below = open(hierarchy_->child(nodes_[slot].node, k));
        nodes_[below].above = slot, nodes_[below].lane = static_cast<std::uint8_t>(k);
        return nodes_[slot].below[k] = below;
    }
    /// Prefetches the child node of box `k`, if it is stored and not open.
    void prefetch(std::uint32_t slot, unsigned k) const
    {
        if constexpr (requires(Hierarchy & h, typename Hierarchy::Node n) { h.prefetch_child(n, k); })
            if (const Node& above = nodes_[slot]; !above.below[k] && !above.leaf(k))
                hierarchy_->prefetch_child(above.node, k);
    }
    /// True for a mesh of many triangles.
    bool has_many() const
    {
        if constexpr (requires { hierarchy_->has_many(); }) return hierarchy_->has_many();
        return false;
    }
    /// Prefetches the child nodes of several boxes, one bit each, if the hierarchy is too large for the caches.
    void prefetch_below(std::uint32_t slot, unsigned boxes) const
    {
        if constexpr (requires { hierarchy_->is_large(); })
            if (hierarchy_->is_large())
                for (boxes &= ~nodes_[slot].masks.leaves; boxes; boxes &= boxes - 1)
                    hierarchy_->prefetch_child(nodes_[slot].node, static_cast<unsigned>(__builtin_ctz(boxes)));
    }
    /// The box `levels` above box `k`, or as far up as nodes are open.
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
