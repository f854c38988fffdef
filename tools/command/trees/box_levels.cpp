#include "trees/box_levels.hpp"

namespace oncollide::tools {
namespace {

struct Lane {
    ObbTree::Node node;
    unsigned lane;
    bool single;
};

void add_boxes(const ObbTree& tree, ObbTree::Node index, std::vector<Lane>& places,
               std::vector<CoveringVolume>& volumes)
{
    OpenBoxes boxes;
    const LaneMasks masks = tree.open(index, nullptr, boxes);
    for (unsigned k = 0; k < 8 && boxes.c[0][k] < 1e29f; ++k) {
        CoveringVolume& box = volumes.emplace_back();
        places.push_back({index, k, (masks.singles >> k & 1) != 0});
        const double rounding = 0x1p-23 * Eigen::Vector3d(boxes.c[0][k], boxes.c[1][k], boxes.c[2][k]).norm();
        for (int i = 0; i < 3; ++i) {
            box.centre[i] = tree.centre()[i] + double(boxes.c[i][k]);
            box.half[i] = boxes.h[i][k] + rounding;
            for (int component = 0; component < 3; ++component) box.axes(component, i) = boxes.axis[i][component][k];
        }
    }
}

} // namespace

std::vector<std::vector<CoveringVolume>> box_levels(ObbTree& tree, std::size_t most)
{
    std::vector<std::vector<CoveringVolume>> levels(1);
    std::vector<Lane> places, next;
    add_boxes(tree, ObbTree::root, places, levels.back());
    for (;;) {
        next.clear();
        std::vector<CoveringVolume> volumes;
        for (std::size_t i = 0; i < places.size() && volumes.size() <= most; ++i) {
            const auto [index, lane, single] = places[i];
            if (!single)
                add_boxes(tree, tree.child(index, lane), next, volumes);
            else
                next.push_back(places[i]), volumes.push_back(levels.back()[i]);
        }
        if (volumes.size() == levels.back().size() || volumes.size() > most) return levels;
        levels.push_back(std::move(volumes));
        places.swap(next);
    }
}

} // namespace oncollide::tools
