#include <oncollide/narrowphase/obb/obb_tree_deform.hpp>

#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include <oncollide/narrowphase/obb/oriented_box.hpp>

namespace oncollide {

/// Boxes of one node divide the triangles of the box above, and hold them.
std::string ObbTree::fault_of_node(Node index, std::uint32_t begin, std::uint32_t count) const
{
    const auto fault = [&](unsigned k, const char* what) { return fmt::format("node {}, box {}: {}", index, k, what); };
    const BoxNode& from = node(index);
    if (from.lanes < 1 || from.lanes > most_lanes) return fault(0, "is not one of eight boxes");
    if ((from.leaves >> from.lanes) || (from.singles & ~from.leaves)) return fault(0, "has marks of absent boxes");
    const bool fits = !deformation_ || deformation_->fits(index);
    std::uint32_t next = begin;
    for (unsigned k = 0; k < from.lanes; ++k) {
        const std::uint32_t first = begin_of(index, k), size = count_of(index, k);
        if (first != next || size == 0 || size > begin + count - next)
            return fault(k, "does not continue the triangles of the box before it");
        next += size;
        if ((from.leaves >> k & 1) != (size <= leaf_triangles)) return fault(k, "has a wrong mark of a leaf");
        for (std::uint32_t i = first; order_ && fits && i < first + size; ++i)
            for (const Eigen::Vector3d& corner : corners(order_[i]))
                if (!oncollide::holds(from, k, corner - centre_)) return fault(k, "does not hold its triangles");
    }
    return next == begin + count ? "" : fault(0, "some triangles of the box above are in no box");
}

std::string ObbTree::validate() const
{
    if (chunked_) return {};
    struct Range {
        Node index;
        std::uint32_t begin, count;
    };
    const auto all = static_cast<std::uint32_t>(mesh_->triangles.size());
    std::vector<Range> waiting{{root, 0, all}};
    std::uint32_t found = 0;
    while (!waiting.empty()) {
        const Range range = waiting.back();
        waiting.pop_back();
        if (++found > nodes()) return fmt::format("more nodes are reached than the {} that exist", nodes());
        if (std::string fault = fault_of_node(range.index, range.begin, range.count); !fault.empty()) return fault;
        for (unsigned k = 0; k < node(range.index).lanes; ++k)
            if (is_grown(range.index, k))
                waiting.push_back({grown(range.index, k), begin_of(range.index, k), count_of(range.index, k)});
    }
    if (found != nodes()) return fmt::format("{} of {} nodes are reached", found, nodes());
    if (!order_) return {};
    std::vector<bool> seen(all);
    for (std::uint32_t place = 0; place < all; ++place) {
        if (order_[place] >= all || seen[order_[place]]) return fmt::format("triangle {} is held twice", order_[place]);
        seen[order_[place]] = true;
    }
    return {};
}

} // namespace oncollide
