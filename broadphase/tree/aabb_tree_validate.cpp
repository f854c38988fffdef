#include <oncollide/broadphase/tree/aabb_tree.hpp>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace oncollide {

namespace {

bool encloses(const float outer[6], const float inner[6])
{
    for (int c = 0; c < 3; ++c)
        if (!(outer[c] <= inner[c] && inner[3 + c] <= outer[3 + c])) return false;
    return true;
}

bool is_nothing(const float box[6])
{
    for (int c = 0; c < 3; ++c)
        if (!std::isinf(box[c]) || box[c] < 0 || box[3 + c] != -box[c]) return false;
    return true;
}

void read_box(const float* blocks, std::uint32_t place, float box[6])
{
    const float* p = blocks + std::size_t{place / node_width} * aabb_block + place % node_width;
    for (std::size_t c = 0; c < 6; ++c) box[c] = p[c * node_width];
}

} // namespace

/// Each body is in exactly one slot, whose box encloses it; other slots are empty.
std::string AabbTree::fault_of_slots(const BodyColumns& columns, double margin) const
{
    std::uint32_t found = 0;
    for (std::uint32_t place = 0; place < size(); ++place) {
        float box[6], own[6];
        box_at(place, box);
        const std::uint32_t body = order_[place];
        if (body == no_body) {
            if (!is_nothing(box)) return fmt::format("slot {} is empty, but has a box", place);
            continue;
        }
        ++found;
        if (body >= places_.size() || places_[body] != place)
            return fmt::format("slot {} holds body {}, which is registered elsewhere", place, body);
        round(columns.boxes[body], margin, own);
        if (!encloses(box, own)) return fmt::format("slot {} does not enclose its body {}", place, body);
        for (float x : box)
            if (!(std::abs(x) <= farthest_))
                return fmt::format("slot {} is farther out than the farthest coordinate", place);
    }
    return found == bodies_ ? "" : fmt::format("{} slots are used for {} bodies", found, bodies_);
}

/// Each node encloses its children, and knows the number, the layers and the group of the bodies below it.
std::string AabbTree::fault_of_level(int number, const BodyColumns& columns) const
{
    const Level &level = at(number), &below = at(number - 1);
    for (std::uint32_t node = 0; node < level.count; ++node) {
        const auto fault = [&](const char* what) { return fmt::format("level {}, node {}: {}", number, node, what); };
        float box[6], child[6];
        read_box(level.blocks.data(), node, box);
        std::uint32_t bodies = 0;
        for (std::uint32_t i = node * node_width; i < std::min((node + 1) * node_width, below.count); ++i) {
            read_box(below.blocks.data(), i, child);
            if (!is_nothing(child) && !encloses(box, child)) return fault("does not enclose a child");
            const std::uint32_t body = number == 1 ? order_[i] : no_body;
            bodies += number == 1 ? body != no_body : below.nodes[i].bodies;
            if (number == 1 && body == no_body) continue;
            if (filters_.layers) {
                const std::uint32_t layers = number == 1 ? columns.layers[body] : below.layers[i],
                                    masks = number == 1 ? columns.masks[body] : below.masks[i];
                if ((layers & ~level.layers[node]) || (masks & ~level.masks[node]))
                    return fault("lacks a layer of a child");
            }
            if (filters_.groups && level.groups[node] != mixed_groups) {
                const std::uint32_t group = number == 1 ? forbidding_group(columns.groups[body]) : below.groups[i];
                if (group != 0 && group != level.groups[node]) return fault("lacks the group of a child");
            }
        }
        if (bodies != level.nodes[node].bodies) return fault("has a wrong number of bodies");
    }
    return {};
}

/// Each moving body is marked in all nodes above it.
std::string AabbTree::fault_of_marks(const std::uint8_t* states, std::uint8_t bits) const
{
    for (std::uint32_t place = 0; place < size(); ++place) {
        if (order_[place] == no_body || !(states[order_[place]] & bits)) continue;
        std::uint32_t i = place;
        for (const Level& level : levels_) {
            if (!(level.moving[i / node_width] >> i % node_width & 1))
                return fmt::format("body {} moves, but is not marked in every node above it", order_[place]);
            i /= node_width;
        }
    }
    return {};
}

std::string AabbTree::validate(const BodyColumns& columns, double margin, const std::uint8_t* states,
                               std::uint8_t bits) const
{
    std::uint32_t count = size();
    for (std::size_t i = 0; i < levels_.size(); ++i) {
        if (levels_[i].count != count)
            return fmt::format("level {} has {} nodes; must be {}", i, levels_[i].count, count);
        if ((count > node_width) != (i + 1 < levels_.size())) return "has a wrong number of levels";
        count = (count + node_width - 1) / node_width;
        if (levels_[i].blocks.size() < std::size_t{count} * aabb_block || levels_[i].moving.size() < count ||
            view_.level[i].blocks != levels_[i].blocks.data() || view_.level[i].count != levels_[i].count)
            return fmt::format("level {} is not as the search sees it", i);
    }
    if (std::string fault = fault_of_slots(columns, margin); !fault.empty()) return fault;
    for (int level = 1; level < view_.levels; ++level)
        if (std::string fault = fault_of_level(level, columns); !fault.empty()) return fault;
    return states ? fault_of_marks(states, bits) : "";
}

} // namespace oncollide
