// The octree: boxes in tree order, and the search for pairs.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <oncollide/broadphase/box_kernel.hpp>
#include <oncollide/broadphase/broad_phase.hpp>

namespace oncollide {

/// A box rounded outward to float, relative to the middle of all boxes.
struct FloatBox {
    float lo[3], hi[3];
    std::uint32_t body;
    std::uint32_t is_static;
};

/// Boxes in [begin, end): first the straddlers, up to `straddle_end`, then the children's, child by child.
struct SpatialNode {
    std::uint32_t begin, straddle_end, end;
    std::uint32_t first_child, children; ///< 0 children: a leaf, all its boxes straddle
    float lo[3], hi[3];                  ///< around all boxes of the node
    bool has_moving;
};

/// Reorders `boxes` into straddlers first, then one run for each child, and returns the children's begins (the last one
/// ends at boxes.size()). An empty answer makes the node a leaf.
class NodeSplitter {
public:
    virtual ~NodeSplitter() = default;
    virtual std::span<const std::uint32_t> split(std::span<FloatBox> boxes) = 0;
};

std::unique_ptr<NodeSplitter> make_octree_splitter();

/// Boxes as float columns, padded so that the kernel may read past the end.
struct BoxColumns {
    std::array<std::vector<float>, 6> columns;

    void assign(std::span<const FloatBox> boxes);
    BoxColumnsView view() const;
};

/// Rounds `boxes` of `bodies`, each grown by margin / 2, outward to float relative to their common middle.
void round_outward(std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies, const BodyFilter& filter,
                   double margin, std::vector<FloatBox>& out);

} // namespace oncollide
