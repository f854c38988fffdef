// Oriented boxes against oriented boxes, one implementation an instruction set. Plain data in, plain data out.
#pragma once
#include <cstdint>

#include <oncollide/narrowphase/obb/box_node.hpp>

namespace oncollide {

/// A direction of length 1 at most, in A's frame, and how far in it the other box, or what is in it, reaches.
struct BoxLine {
    float direction[3];
    float other_reach;
};

struct OrientedBoxKernel {
    /// @param placement  null: the boxes stay where they are
    /// Lanes past the node's last box get centres at 1e30: far from everything.
    void (*open)(const BoxNode& node, const BoxPlacement* placement, OpenBoxes& out);
    /// Of the triangles of a row, each a box of its own.
    void (*open_triangles)(const TriangleRow& row, const BoxPlacement* placement, OpenBoxes& out);
    /// @param row    relative to `from` of the placement
    /// @param lanes  a bit for each box that is there; the others are as far away as those past the last of a node
    void (*open_octants)(const OctantBoxes& row, unsigned lanes, const BoxPlacement* placement, OpenBoxes& out);
    /// One bit for each box that box `k` of `other` may touch: whose gap is at most `cutoff`.
    /// @param gaps     out: lower bounds on the distances, the margins taken off, other rounding aside: the most that a
    /// separating axis shows, be it
    ///                 one of the six face normals or of the nine cross products of edges. Negative: overlap
    /// @param nearest  in and out, by lane: the smallest gap above `cutoff`
    /// Source: Gottschalk, Lin and Manocha, "OBBTree: a hierarchical structure for rapid interference detection",
    /// SIGGRAPH 1996.
    using Compare = unsigned(const OpenBoxes& boxes, const OpenBoxes& other, unsigned k, float cutoff, float (&gaps)[8],
                             float (&nearest)[8]);
    Compare* compare;
    /// The same, with the line of centres for one axis more, and the line for another: for boxes far apart the gaps
    /// come much nearer to the distances, above all along the line that joins the nearest points.
    using CompareFar = unsigned(const OpenBoxes& boxes, const OpenBoxes& other, unsigned k, const BoxLine& line,
                                float cutoff, float (&gaps)[8], float (&nearest)[8]);
    CompareFar* compare_far;
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
