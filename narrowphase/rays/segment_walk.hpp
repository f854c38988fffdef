#pragma once
#include <algorithm>
#include <optional>
#include <vector>

#include <oncollide/broadphase/segment_part.hpp>
#include <oncollide/narrowphase/obb/hierarchy.hpp>
#include <oncollide/narrowphase/obb/oriented_box.hpp>

namespace oncollide {

/// Finds the primitives of a hierarchy that a segment may meet, near its first point first. One thread's working
/// memory.
template <BoxHierarchy Tree>
class SegmentWalk {
public:
    using Primitive = typename Tree::Primitive;

    /// Calls take(primitive) for every primitive in boxes that the segment meets before the fraction `reach` of its
    /// length, and possibly for others. take() returns the new reach: e.g. 1 to go on, the fraction of a hit to find
    /// nearer ones, or -1 to stop. Boxes come in the order of lower bounds of their fractions within each node.
    /// @param segment  in the geometry's frame, exact
    /// @param reach    the first reach
    template <class Take>
    void walk(Tree& tree, const Segment& segment, Take take, double reach = 1);

private:
    struct Box {
        float entry; ///< as OrientedBoxKernel::on_segment() returns it
        bool leaf;
        unsigned lane;
        typename Tree::Node node;
    };
    void open(Tree& tree, const typename Tree::Node& node, const SegmentLine& line);

    std::vector<Box> boxes_; ///< to visit, the next one last
};

/// Adds the boxes of a node that the segment meets, the nearest last.
template <BoxHierarchy Tree>
void SegmentWalk<Tree>::open(Tree& tree, const typename Tree::Node& node, const SegmentLine& line)
{
    OpenBoxes boxes;
    const LaneMasks masks = tree.open(node, nullptr, boxes);
    float entry[8];
    const std::size_t first = boxes_.size();
    for (unsigned met = oriented_box_kernel().on_segment(boxes, line, entry); met; met &= met - 1) {
        const auto lane = static_cast<unsigned>(__builtin_ctz(met));
        const Box box{entry[lane], (masks.leaves >> lane & 1) != 0, lane, node};
        if constexpr (requires { tree.prefetch_child(node, lane); })
            if (!box.leaf) tree.prefetch_child(node, lane);
        boxes_.push_back(box);
        std::size_t place = boxes_.size() - 1;
        for (; place > first && boxes_[place - 1].entry < box.entry; --place) boxes_[place] = boxes_[place - 1];
        boxes_[place] = box;
    }
}

template <BoxHierarchy Tree>
template <class Take>
void SegmentWalk<Tree>::walk(Tree& tree, const Segment& segment, Take take, double reach)
{
    const Eigen::Vector3d centre = tree.centre(), radius = Eigen::Vector3d::Constant(tree.radius());
    const std::optional<SegmentPart> part = part_in(segment, {centre - radius, centre + radius});
    if (!part) return;
    const SegmentLine line = line_of(*part, centre, 4 * tree.radius()); // corners of boxes lie farther out
    // Entries are in the part: -1 is its begin, 1 its end.
    const double length = part->end - part->begin;
    const auto last_entry = [&](double allowed) {
        if (allowed < part->begin || !(length > 0)) return allowed < part->begin ? -2.0f : 2.0f;
        return static_cast<float>((2 * (allowed - part->begin) / length - 1) * (1 + 0x1p-20) + 0x1p-20);
    };
    float last = last_entry(reach);
    if (last < -1) return;
    boxes_.clear();
    open(tree, Tree::root, line);
    while (!boxes_.empty()) {
        const Box box = boxes_.back();
        boxes_.pop_back();
        if (std::max(box.entry, -1.0f) > last) continue;
        if (!box.leaf) {
            open(tree, tree.child(box.node, box.lane), line);
            continue;
        }
        for (const Primitive& primitive : tree.primitives(box.node, box.lane)) {
            last = std::min(last, last_entry(take(primitive)));
            if (last < -1) return;
        }
    }
}

} // namespace oncollide
