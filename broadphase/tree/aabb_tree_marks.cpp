// The marks by which searches skip nodes: moving bodies below, layers and groups.
#include <algorithm>
#include <functional>

#include <oncollide/broadphase/tree/aabb_tree.hpp>

namespace oncollide {

void AabbTree::set_moving(const std::uint8_t* states, std::uint8_t bits)
{
    ONCOLLIDE_ASSERT(states || bodies_ == 0);
    for (std::size_t level = 0; level < levels_.size(); ++level) {
        Level& l = levels_[level];
        for (std::uint32_t node = 0; node < l.moving.size(); ++node) {
            unsigned mask = 0;
            for (std::uint32_t i = node * node_width; i < std::min((node + 1) * node_width, l.count); ++i) {
                const bool moves =
                    level == 0 ? order_[i] != no_body && (states[order_[i]] & bits) : levels_[level - 1].moving[i] != 0;
                mask |= unsigned(moves) << i % node_width;
            }
            l.moving[node] = static_cast<std::uint16_t>(mask);
        }
    }
}

namespace {

/// The group of the bodies of two nodes.
std::uint32_t joined(std::uint32_t a, std::uint32_t b)
{
    return a == b || b == 0 ? a : a == 0 ? b : mixed_groups;
}

} // namespace

void AabbTree::set_filters(const BodyColumns& columns, ForbiddingFilters which)
{
    ONCOLLIDE_ASSERT(columns.layers.size() == columns.masks.size());
    forget_filters();
    if (!which.any()) return;
    filters_ = which;
    extend_levels();
    for (std::uint32_t body : order_)
        if (body != no_body) add_filters(body, columns);
}

void AabbTree::add_filters(std::uint32_t body, const BodyColumns& columns)
{
    ONCOLLIDE_ASSERT(!filters_.layers || (body < columns.layers.size() && body < columns.masks.size()));
    ONCOLLIDE_ASSERT(!filters_.groups || body < columns.groups.size());
    // The way up ends at a node that already has these filters, because all its ancestors have them, too.
    if (filters_.layers) {
        const std::uint32_t layers = columns.layers[body], masks = columns.masks[body];
        std::uint32_t node = places_[body];
        for (std::size_t level = 1; level < levels_.size(); ++level) {
            Level& l = levels_[level];
            node /= node_width;
            if ((l.layers[node] & layers) == layers && (l.masks[node] & masks) == masks) break;
            l.layers[node] |= layers, l.masks[node] |= masks;
        }
    }
    if (filters_.groups) {
        const std::uint32_t group = forbidding_group(columns.groups[body]);
        std::uint32_t node = places_[body];
        for (std::size_t level = 1; level < levels_.size(); ++level) {
            std::uint32_t& mine = levels_[level].groups[node /= node_width];
            const std::uint32_t both = joined(mine, group);
            if (both == mine) break;
            mine = both;
        }
    }
}

/// New nodes get the union of the filters below them.
void AabbTree::extend_filters()
{
    for (std::size_t level = 1; level < levels_.size(); ++level) {
        Level& l = levels_[level];
        const Level& below = levels_[level - 1];
        const auto extend = [&](std::vector<std::uint32_t> Level::*column, auto join) {
            std::vector<std::uint32_t>& mine = l.*column;
            const auto old = static_cast<std::uint32_t>(mine.size());
            mine.resize(l.count, 0);
            if (level == 1) return; // level 0 holds bodies, whose filters add_filters() adds
            for (std::uint32_t i = old * node_width; i < below.count; ++i)
                mine[i / node_width] = join(mine[i / node_width], (below.*column)[i]);
        };
        if (filters_.layers) extend(&Level::layers, std::bit_or{}), extend(&Level::masks, std::bit_or{});
        if (filters_.groups) extend(&Level::groups, joined);
    }
}

void AabbTree::forget_filters()
{
    filters_ = {};
    for (AabbLevelView& level : view_.level) level.layers = level.masks = level.groups = nullptr;
    for (Level& level : levels_) level.layers.clear(), level.masks.clear(), level.groups.clear();
}

} // namespace oncollide
