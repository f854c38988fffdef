#pragma once
#include <algorithm>
#include <optional>

#include <oncollide/broadphase/segment_part.hpp>
#include <oncollide/narrowphase/obb/hierarchy.hpp>
#include <oncollide/narrowphase/obb/oriented_box.hpp>
#include <oncollide/narrowphase/rays/nearest_boxes.hpp>

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
    /// @param segment  the segment in the geometry's frame, exact
    /// @param reach    the first reach
    template <class Take>
    void walk(Tree& tree, const Segment& segment, Take take, double reach = 1);

private:
    struct Box {
        float entry; ///< as OrientedBoxKernel::node_on_segment() returns it
        bool leaf;
        std::uint8_t lane;
        typename Tree::Node node;
    };
    void open(Tree& tree, const typename Tree::Node& node, const SegmentLine& line, float last);

    NearestBoxes<Box> waiting_;
};

/// Adds the boxes of a node that the segment meets, the nearest last.
/// @param last  boxes that it enters later are left out
template <BoxHierarchy Tree>
void SegmentWalk<Tree>::open(Tree& tree, const typename Tree::Node& node, const SegmentLine& line, float last)
{
    float entry[8];
    unsigned leaves;
    waiting_.begin_node();
    for (unsigned met = tree.on_segment(node, line, entry, leaves); met; met &= met - 1) {
        const auto lane = static_cast<unsigned>(__builtin_ctz(met));
        if (entry[lane] > last) continue;
        const Box box{entry[lane], (leaves >> lane & 1) != 0, static_cast<std::uint8_t>(lane), node};
        if (box.leaf)
            tree.prefetch_primitives(node, lane);
        else
            tree.prefetch_child(node, lane), tree.prefetch_order(node, lane);
        waiting_.add(box);
    }
}

template <BoxHierarchy Tree>
template <class Take>
void SegmentWalk<Tree>::walk(Tree& tree, const Segment& segment, Take take, double reach)
{
    const Eigen::Vector3d centre = tree.centre();
    const std::optional<SegmentPart> part = part_in(segment, tree.bounds());
    if (!part) return;
    const SegmentLine line = line_of(*part, centre, 4 * tree.radius()); // corners of boxes lie farther out
    // Entries are relative to the part: -1 is its beginning, 1 its end.
    const double length = part->end - part->begin;
    const auto last_entry = [&](double allowed) {
        if (allowed < part->begin || !(length > 0)) return allowed < part->begin ? -2.0f : 2.0f;
        return static_cast<float>((2 * (allowed - part->begin) / length - 1) * (1 + 0x1p-20) + 0x1p-20);
    };
    float last = last_entry(reach);
    if (last < -1) return;
    waiting_.clear();
    open(tree, tree.below_root(), line, last);
    while (!waiting_.empty()) {
        const Box box = waiting_.take();
        if (std::max(box.entry, -1.0f) > last) continue;
        if (!box.leaf) {
            open(tree, tree.child(box.node, box.lane), line, last);
            continue;
        }
        for (const Primitive& primitive : tree.primitives(box.node, box.lane)) {
            last = std::min(last, last_entry(take(primitive)));
            if (last < -1) return;
        }
    }
}

} // namespace oncollide
