#pragma once
#include <cstddef>
#include <cstdint>

namespace oncollide {

/// Eight oriented boxes around parts of one mesh, in its tree's frame, quantised. Box k has its centre at origin + unit
/// (x, y, z)[k], half-extents unit (hx, hy, hz)[k], and axes rotated by the quaternion (qw, qx, qy, qz)[k] / 32767,
/// normalised as axes_of() does. Lanes past the last box are zero.
///
/// A node whose boxes are all leaves is a BoxNode; any other node is an InnerNode.
struct alignas(64) BoxNode {
    std::int16_t x[8], y[8], z[8];
    std::int16_t qw[8], qx[8], qy[8], qz[8];
    std::uint16_t hx[8], hy[8], hz[8];
    float origin[3];
    float unit;
    std::uint32_t begin; ///< position in the tree's order of the triangles of the first box
    std::uint32_t
        offsets;          ///< four bits per box: box k's triangles begin at begin + its offset, if all boxes are leaves
    std::uint32_t fitted; ///< the version of the mesh (ObbTree::deform) that the boxes fit
    std::uint8_t lanes;   ///< number of boxes
    std::uint8_t leaves;  ///< one bit for each box that is a leaf
    std::uint8_t singles; ///< one bit for each box of one triangle; other leaves have two
    bool inner;
};
static_assert(sizeof(BoxNode) == 192);

/// A node with at least one box that is not a leaf.
struct InnerNode {
    BoxNode boxes;
    std::uint32_t child[8]; ///< child node of box k; 0: not grown yet, or a leaf. Other threads may set it
    std::uint32_t begin[8]; ///< the triangles of box k are [begin[k], begin[k] + count[k]) of the tree's order
    std::uint32_t count[8];
};

/// p -> rotation (p - from) + translation, or, if not rotated, p - from.
struct BoxPlacement {
    float from[3];
    bool rotated;
    float rotation[9]; ///< row-major, a rotation
    float translation[3];
};

/// The rounding allowance of a node's boxes, as a share of the node's size: the largest sum of half-extents of a box,
/// plus, for stored boxes, the distance of the box from the node's origin.
constexpr float box_margin = 0x1p-15f;

/// Eight boxes of one node in the layout of the box test: in A's frame, metres. Box k is the set of points c + u a1 + v
/// a2 + w a3 with |u| <= h1, |v| <= h2, |w| <= h3.
struct alignas(32) OpenBoxes {
    float c[3][8];
    float axis[3][3][8]; ///< [which axis][component]
    float h[3][8];
    float size[8]; ///< squared radii
    float margin;  ///< subtracted from gaps to other boxes: box_margin times the size, and any other error of the boxes
};

/// Eight axis-aligned boxes, made of two intervals on each axis: bits 0, 1 and 2 of k select the interval of box k on
/// x, y and z.
struct OctantBoxes {
    float centre[3][2], half[3][2];
};

/// Up to eight triangles of one node: a corner of each, relative to `from` of the placement, and the two sides from it
/// to the other corners, divided by the size, so that components are at most 1. All 0 in lanes past the last.
struct TriangleRow {
    float corner[3][8], sides[2][3][8];
    float size;
    std::uint32_t lanes;
};

} // namespace oncollide
