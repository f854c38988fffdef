#pragma once
#include <algorithm>
#include <cmath>
#include <concepts>
#include <optional>

#include <oncollide/base/simd/cpu_features.hpp>
#include <oncollide/broadphase/segment_part.hpp>
#include <oncollide/narrowphase/obb/terrain_tree.hpp>
#include <oncollide/narrowphase/rays/nearest_boxes.hpp>
#include <oncollide/narrowphase/rays/ray_part.hpp>
#include <oncollide/narrowphase/rays/segment_walk.hpp>
#include <oncollide/narrowphase/rays/terrain_kernel.hpp>

namespace oncollide {

/// The build of the kernel for this processor.
inline const TerrainRayKernel& terrain_ray_kernel()
{
    static const TerrainRayKernel kernel = ONCOLLIDE_CHOOSE_TO_AVX2(terrain_ray_kernel);
    return kernel;
}

/// The walk through the blocks of a terrain: upright boxes, cut by two parallel planes, down to eight cells whose 16
/// triangles are tested at once.
template <>
class SegmentWalk<TerrainTree> {
public:
    /// As SegmentWalk::walk() of other trees. take may be called as take(triangle, certain), as RayWalk does.
    template <class Take>
    void walk(const TerrainTree& tree, const Segment& segment, Take take, double reach = 1);

private:
    struct Box {
        float entry, height; ///< height: of the block's middle, from the tree's centre
        std::uint32_t lane;
        TerrainTree::Node node;
    };
    /// Returns the new `last`.
    template <class Take>
    float take_cells(const TerrainTree& tree, const TerrainTree::Node& node, float height, const RayPart& part,
                     float last, Take& take);

    NearestBoxes<Box> waiting_;
};

template <class Take>
float SegmentWalk<TerrainTree>::take_cells(const TerrainTree& tree, const TerrainTree::Node& node, float height,
                                           const RayPart& part, float last, Take& take)
{
    const Terrain& terrain = tree.terrain();
    // Blocks beyond the last column or row have no width.
    if (node.x >= terrain.cells_x() || node.y >= terrain.cells_y()) return last;
    // The line's point near the cells.
    const Eigen::Vector3d middle(terrain.origin().x() + (node.x + 2.0) * terrain.spacing().x(),
                                 terrain.origin().y() + (node.y + 1.0) * terrain.spacing().y(),
                                 tree.centre().z() + height);
    const double along = part.direction.dot(middle - tree.centre() - part.middle);
    TerrainCells cells;
    tree.open_cells(node, tree.centre() + part.middle + along * part.direction, cells);
    const float direction[3] = {float(part.direction.x()), float(part.direction.y()), float(part.direction.z())};
    CellHits hits = terrain_ray_kernel().cells(cells, direction, static_cast<float>(part.error));
    const std::uint32_t columns = std::min(terrain.cells_x() - node.x, 4u),
                        rows = std::min(terrain.cells_y() - node.y, 2u);
    unsigned there = (1u << columns) - 1;
    if (rows > 1) there |= there << 4;
    if (!part.covers(along, double(hits.reach))) hits.even.certain = hits.odd.certain = 0;
    const auto take_one = [&](std::uint32_t triangle, bool certain) {
        if constexpr (std::invocable<Take&, std::uint32_t, bool>)
            return take(triangle, certain);
        else
            return take(triangle);
    };
    for (unsigned met = (hits.even.possible | hits.odd.possible) & there; met; met &= met - 1) {
        const auto k = static_cast<unsigned>(__builtin_ctz(met));
        const std::uint32_t first = 2 * ((node.y + k / 4) * terrain.cells_x() + node.x + k % 4);
        const std::pair<std::uint32_t, const RayHits*> both[] = {{first, &hits.even}, {first + 1, &hits.odd}};
        for (const auto& [triangle, of] : both) {
            if (!(of->possible >> k & 1)) continue;
            last = std::min(last, part.last(take_one(triangle, (of->certain >> k & 1) != 0)));
            if (last < 0) return last;
        }
    }
    return last;
}

template <class Take>
void SegmentWalk<TerrainTree>::walk(const TerrainTree& tree, const Segment& segment, Take take, double reach)
{
    const std::optional<SegmentPart> of_segment = part_in(segment, tree.terrain().bounds());
    if (!of_segment) return;
    const RayPart part(segment, *of_segment, tree.centre(), tree.radius(), 0);
    const TerrainLine line{part.line,
                           {float(part.direction.x()), float(part.direction.y()), float(part.direction.z())},
                           static_cast<float>(part.widened)};
    float last = part.last(reach);
    if (last < 0) return;
    waiting_.clear();
    const Eigen::Vector3d half = of_segment->half.cwiseAbs().array() + 2 * of_segment->error;
    TerrainTree::Node next = tree.node_around({of_segment->middle - half, of_segment->middle + half});
    auto height = static_cast<float>(part.middle.z()); // if it begins with cells
    for (;;) {
        if (next.level == 0) {
            last = take_cells(tree, next, height, part, last, take);
            if (last < 0) return;
        } else {
            TerrainBlocks blocks;
            tree.open_blocks(next, tree.centre(), blocks);
            float entry[8];
            waiting_.begin_node();
            for (unsigned met = terrain_ray_kernel().blocks(blocks, line, last, entry); met; met &= met - 1) {
                const auto lane = static_cast<unsigned>(__builtin_ctz(met));
                waiting_.add({entry[lane], 0.5f * (blocks.low[lane] + blocks.high[lane]), lane, next});
            }
        }
        Box box;
        do {
            if (waiting_.empty()) return;
            box = waiting_.take();
        } while (box.entry > last);
        next = tree.child(box.node, box.lane), height = box.height;
    }
}

} // namespace oncollide
