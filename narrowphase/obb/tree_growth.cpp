#include <oncollide/narrowphase/obb/tree_growth.hpp>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <numeric>

#include <oncollide/narrowphase/obb/obb_tree.hpp>

namespace oncollide {

namespace {

constexpr std::uint32_t child_line = offsetof(InnerNode, child) / sizeof(NodeLine);
static_assert(offsetof(InnerNode, child) % sizeof(NodeLine) == 0 &&
              sizeof(InnerNode::child) + sizeof(InnerNode::begin) == sizeof(NodeLine));

} // namespace

void ObbTree::copy_growth(std::uint32_t from, TreeGrowth& growth) const
{
    ONCOLLIDE_ASSERT(!chunked_);
    growth.clear();
    const std::lock_guard lock(growing_);
    growth.from = from, growth.lines = lines_;
    const auto line = [&](std::uint32_t number) -> const NodeLine& {
        return blocks_[number / lines_per_block][number % lines_per_block];
    };
    const auto add_order = [&](std::uint32_t begin, std::uint32_t count) {
        growth.sorted.push_back({begin, count});
        const std::size_t at = growth.order.size();
        growth.order.resize(at + count);
        if (order_)
            std::memcpy(growth.order.data() + at, order_ + begin, count * sizeof(std::uint32_t));
        else
            std::iota(growth.order.begin() + static_cast<std::ptrdiff_t>(at), growth.order.end(), begin);
    };
    growth.added.resize(growth.lines - from);
    for (std::uint32_t number = from; number < growth.lines;) { // up to the end of each block
        const std::uint32_t count = std::min(growth.lines - number, lines_per_block - number % lines_per_block);
        std::memcpy(growth.added.data() + (number - from), &line(number), count * sizeof(NodeLine));
        number += count;
    }
    if (from == 0) return add_order(0, static_cast<std::uint32_t>(mesh_->triangles.size()));
    std::vector<Node> older{root};
    while (!older.empty()) {
        const Node index = older.back();
        older.pop_back();
        if (!node(index).inner) continue;
        const InnerNode& inner = inner_at(blocks_, index);
        bool changed = false;
        for (unsigned k = 0; k < inner.boxes.lanes; ++k) {
            const Node child = grown(index, k);
            if (child == 0) continue;
            if (child < from) {
                older.push_back(child);
            } else {
                changed = true;
                add_order(inner.begin[k], inner.count[k]);
            }
        }
        if (!changed) continue;
        growth.changed.push_back(index + child_line);
        growth.contents.push_back(line(index + child_line));
    }
}

} // namespace oncollide
