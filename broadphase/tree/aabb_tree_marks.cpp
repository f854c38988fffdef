// The marks by which searches skip nodes: moving bodies below, and layers.
#include <algorithm>

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

void AabbTree::set_layers(const BodyColumns& columns)
{
    ONCOLLIDE_ASSERT(columns.layers.size() == columns.masks.size());
    forget_layers();
    layers_known_ = true;
    extend_levels();
    for (std::uint32_t body : order_)
        if (body != no_body) add_layers(body, columns);
}

void AabbTree::add_layers(std::uint32_t body, const BodyColumns& columns)
{
    ONCOLLIDE_ASSERT(layers_known_ && body < columns.layers.size() && body < columns.masks.size());
    const std::uint32_t layers = columns.layers[body], masks = columns.masks[body];
    std::uint32_t node = places_[body];
    for (std::size_t level = 1; level < levels_.size(); ++level) {
        Level& l = levels_[level];
        node /= node_width;
        if ((l.layers[node] & layers) == layers && (l.masks[node] & masks) == masks) return; // as do all ancestors
        l.layers[node] |= layers, l.masks[node] |= masks;
    }
}

/// New nodes get the union of the layers and masks below them.
void AabbTree::extend_layers()
{
    for (std::size_t level = 1; level < levels_.size(); ++level) {
        Level& l = levels_[level];
        const auto old = static_cast<std::uint32_t>(l.layers.size());
        l.layers.resize(l.count, 0), l.masks.resize(l.count, 0);
        if (level == 1) continue;
        const Level& below = levels_[level - 1];
        for (std::uint32_t i = old * node_width; i < below.count; ++i)
            l.layers[i / node_width] |= below.layers[i], l.masks[i / node_width] |= below.masks[i];
    }
}

void AabbTree::forget_layers()
{
    layers_known_ = false;
    for (AabbLevelView& level : view_.level) level.layers = level.masks = nullptr;
    for (Level& level : levels_) level.layers.clear(), level.masks.clear();
}

} // namespace oncollide
