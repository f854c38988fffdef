// Tests of oriented boxes against oriented boxes, one implementation per instruction set. Plain data in, plain data
// out.
#pragma once
#include <cstdint>

#include <oncollide/broadphase/segment_line.hpp>
#include <oncollide/narrowphase/obb/box_node.hpp>

namespace oncollide {

/// A direction in A's frame, of length 1 at most, and the largest projection onto it of the other box, or of its
/// contents.
struct BoxLine {
    float direction[3];
    float other_reach;
};

/// Linear motion of eight boxes relative to another box, over the times -1 to 1. Boxes are at their places of time 0. A
/// box around c moves by base + turn x c for each unit of time; its contents stay within slack + turn_length times its
/// radius of the place after this motion. The slack must include the error of the boxes' gaps.
struct BoxMotion {
    float base[3], turn[3];
    float turn_length;
    float slack;
};

struct OrientedBoxKernel {
    /// @param placement  null: the boxes are not moved
    /// Lanes past the node's last box get centres at 1e30: far from everything.
    void (*open)(const BoxNode& node, const BoxPlacement* placement, OpenBoxes& out);
    /// One box for each triangle of a row.
    void (*open_triangles)(const TriangleRow& row, const BoxPlacement* placement, OpenBoxes& out);
    /// @param row    the boxes, relative to `from` of the placement
    /// @param lanes  one bit for each box that exists; the others get centres at 1e30
    void (*open_octants)(const OctantBoxes& row, unsigned lanes, const BoxPlacement* placement, OpenBoxes& out);
    /// Returns one bit for each box that box `k` of `other` may touch: its gap is at most `gap_limit`.
    /// @param gaps     out: lower bounds of the distances after subtracting the margins; they ignore other rounding. A
    /// gap is the largest separation along an axis: one of the six face normals or the nine cross products of edges.
    /// Negative: overlap
    /// @param nearest  in and out, by lane: the smallest gap above `gap_limit`
    /// Source: Gottschalk, Lin and Manocha, "OBBTree: a hierarchical structure for rapid interference detection",
    /// SIGGRAPH 1996.
    using Compare = unsigned(const OpenBoxes& boxes, const OpenBoxes& other, unsigned k, float gap_limit,
                             float (&gaps)[8], float (&nearest)[8]);
    Compare* compare;
    /// The same, but `gaps` gets an order instead: the gap plus twice the distance of the centres. The contents of the
    /// box with the least value are the likeliest to meet the contents of the other box.
    Compare* compare_likely;
    /// The same with two more axes, the line of centres and `line`: for boxes far apart the gaps are then much closer
    /// to the distances, above all along the line that joins the nearest points.
    using CompareFar = unsigned(const OpenBoxes& boxes, const OpenBoxes& other, unsigned k, const BoxLine& line,
                                float gap_limit, float (&gaps)[8], float (&nearest)[8]);
    CompareFar* compare_far;
    /// The largest projection of the boxes onto a direction of length 1 at most.
    float (*reach)(const OpenBoxes& boxes, const float (&direction)[3]);
    /// The squared distances of a point from the boxes, without any allowance for rounding.
    void (*from_point)(const OpenBoxes& boxes, const float (&point)[3], float (&distance2)[8]);
    /// Returns one bit for each box that box `k` of `other` may touch at a time up to `until` <= 1.
    /// @param entries  out: lower bounds of the first such times, at least -1
    unsigned (*meet_in_time)(const OpenBoxes& boxes, const OpenBoxes& other, unsigned k, const BoxMotion& motion,
                             float until, float (&entries)[8]);
    /// Returns one bit for each box of a node that the segment may meet: see SegmentLine.
    /// @param entry  out: lower bounds of the parameters, -1 to 1, of the segment's points in the box
    unsigned (*node_on_segment)(const BoxNode& node, const SegmentLine& segment, float (&entry)[8]);
};

namespace baseline {
OrientedBoxKernel oriented_box_kernel();
}
namespace avx2 {
OrientedBoxKernel oriented_box_kernel();
}
namespace avx512 {
OrientedBoxKernel oriented_box_kernel();
}

} // namespace oncollide
