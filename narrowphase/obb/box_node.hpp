#pragma once
#include <cstddef>
#include <cstdint>

namespace oncollide {

/// Eight oriented boxes around parts of one mesh, in its tree's frame, quantised. Box k has its centre at origin + unit
/// (x, y, z)[k], half-extents unit (hx, hy, hz)[k], and axes turned by the quaternion (qw, qx, qy, qz)[k] / 32767,
/// brought to unit length as axes_of() does. Lanes past the last box are zero.
///
/// Where all boxes are leaves that is all; a node with others is an InnerNode.
struct alignas(64) BoxNode {
    std::int16_t x[8], y[8], z[8];
    std::int16_t qw[8], qx[8], qy[8], qz[8];
    std::uint16_t hx[8], hy[8], hz[8];
    float origin[3];
    float unit;
    std::uint32_t begin;    ///< where the triangles of the first box begin, in the tree's order
    std::uint8_t offset[8]; ///< and from there those of box k, where all are leaves
    std::uint8_t lanes;     ///< boxes here
    std::uint8_t leaves;    ///< a bit for each box that counts as a leaf
    std::uint8_t singles;   ///< and for each of one triangle; of the other leaves each has two
    bool inner;
};
static_assert(sizeof(BoxNode) == 192);

/// A node of which not all boxes are leaves.
struct InnerNode {
    BoxNode boxes;
    std::uint32_t child[8]; ///< node of box k's parts; 0: not grown yet, or a leaf. Other threads may set it
    std::uint32_t begin[8]; ///< the triangles of box k are [begin[k], begin[k] + count[k]) of the tree's order
    std::uint32_t count[8];
};

/// p -> rotation (p - from) + translation, or, not turned, p - from.
struct BoxPlacement {
    float from[3];
    bool rotated;
    float rotation[9]; ///< row-major, a rotation
    float translation[3];
};

/// What the boxes of a node allow for rounding, by their size: the most that any of them has of the sum of its
/// half-extents. Stored boxes are relative to their node's origin, whose distance counts, too.
constexpr float box_margin = 0x1p-15f;

/// Eight boxes of one node as the box test reads them: in A's frame, metres. Box k is the points c + u a1 + v a2 + w a3
/// with |u|, |v|, |w| up to h1, h2, h3.
struct alignas(32) OpenBoxes {
    float c[3][8];
    float axis[3][3][8]; ///< [which axis][component]
    float h[3][8];
    float size[8]; ///< squared radii
    float margin;  ///< taken off the gaps to other boxes: box_margin times the size, and what else the boxes may be off
};

/// Eight boxes along the axes, the combinations of two intervals on each axis: box k takes on x, y and z the interval
/// that the bits of k say.
struct OctantBoxes {
    float centre[3][2], half[3][2];
};

/// Up to eight triangles of one node: a corner of each, relative to `from` of the placement, and from there to the
/// other two, divided by the size: components up to 1. All 0 in lanes past the last.
struct TriangleRow {
    float corner[3][8], sides[2][3][8];
    float size;
    std::uint32_t lanes;
};

} // namespace oncollide
