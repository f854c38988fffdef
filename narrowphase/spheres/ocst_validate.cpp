#include <oncollide/narrowphase/spheres/ocst.hpp>

#include <bit>

#include <fmt/format.h>

namespace oncollide {

std::string Ocst::validate() const
{
    if (depth_ < 1 || depth_ > deepest_level) return fmt::format("has the depth {}", depth_);
    if (lists_.size() != nodes_.size()) return fmt::format("{} lists for {} cells", lists_.size(), nodes_.size());
    std::vector<bool> seen(nodes_.size());
    const auto take = [&](std::uint32_t first, std::uint32_t count) {
        for (std::uint32_t i = first; i < first + count; ++i) {
            if (i >= seen.size() || seen[i]) return false;
            seen[i] = true;
        }
        return true;
    };
    struct Cell {
        std::uint32_t node;
        int level;
    };
    std::vector<Cell> waiting{{0, 0}};
    take(0, 1);
    std::uint64_t stored = 0, free = 0;
    while (!waiting.empty()) {
        const auto [node, level] = waiting.back();
        waiting.pop_back();
        ++stored;
        const OcstNode& n = nodes_[node];
        if (!n.expanded() && n.grey()) return fmt::format("cell {} has children, but is not expanded", node);
        if (level + 1 >= depth_) continue;
        const auto children = static_cast<std::uint32_t>(std::popcount(n.grey()));
        if (children && !take(n.first_child, children))
            return fmt::format("cell {}: its children are shared or out of range", node);
        for (std::uint32_t c = 0; c < children; ++c) waiting.push_back({n.first_child + c, level + 1});
    }
    if (stored != stored_) return fmt::format("{} of {} cells are reached", stored, stored_);
    for (std::uint32_t size = 1; size < std::size(free_blocks_); ++size)
        for (std::uint32_t block : free_blocks_[size]) {
            if (!take(block, size)) return fmt::format("the free cells from {} are in use or listed twice", block);
            free += size;
        }
    if (stored + free != nodes_.size())
        return fmt::format("{} cells are neither used nor free", nodes_.size() - stored - free);
    return {};
}

} // namespace oncollide
