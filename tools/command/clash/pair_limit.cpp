#include "clash/pair_limit.hpp"

#include <algorithm>
#include <numeric>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/scenes/model/box_corners.hpp>

namespace oncollide::tools {
namespace {

Aabb box_of(const PartList& list, const Part& part)
{
    const Aabb& bounds = std::get<Mesh>(list.meshes[part.mesh]->data).bounds;
    Aabb box;
    for (const std::uint32_t corner : {0u, 1u, 2u, 3u, 4u, 5u, 6u, 7u}) box.add(part.pose * corner_of(bounds, corner));
    return box;
}

} // namespace

void check_number_of_pairs(const PartList& parts, const ClashSettings& settings)
{
    const std::uint64_t count = parts.parts.size();
    if (count * (count - 1) / 2 <= settings.most_pairs) return;
    std::vector<Aabb> boxes;
    std::vector<std::uint32_t> bodies(count), layers, masks, groups;
    std::iota(bodies.begin(), bodies.end(), 0u);
    for (const Part& part : parts.parts) {
        const auto [layer, mask] = layers_of(parts, part);
        boxes.push_back(box_of(parts, part));
        layers.push_back(layer), masks.push_back(mask), groups.push_back(part.group);
    }
    const auto tree = make_kd_tree({.margin = std::max(settings.clearance, settings.tolerance)});
    const BodyColumns columns{.boxes = boxes, .layers = layers, .masks = masks, .groups = groups};
    tree->add(bodies);
    tree->take_in(columns);
    constexpr std::size_t batch = 16; // parts; each may overlap all others
    std::vector<AabbHit> hits;
    std::uint64_t pairs = 0;
    for (std::size_t first = 0; first < count; first += batch) {
        tree->query(columns, std::span(boxes).subspan(first, std::min(batch, count - first)), hits);
        for (const AabbHit& hit : hits) {
            const auto a = static_cast<std::uint32_t>(first + hit.query);
            pairs += hit.body > a && columns.allows(a, hit.body);
        }
        if (pairs > settings.most_pairs)
            refuse(parts.files.front(),
                   fmt::format("the AABBs of more than {} pairs of parts overlap; are parts many times at one place? "
                               "--max-pairs N allows more, which take about 1 KB of memory each",
                               settings.most_pairs));
    }
}

} // namespace oncollide::tools
