// The distance of a convex solid from boxes and from the cells of a terrain, one implementation per instruction set.
// Plain data in, plain data out.
#pragma once
#include <oncollide/narrowphase/obb/box_node.hpp>
#include <oncollide/narrowphase/obb/oriented_box_kernel.hpp>

namespace oncollide {

/// A convex solid, or a convex solid around it, in the frame of a hierarchy's boxes. In a direction u of length 1, with
/// the components w along its axes, it extends at most radius + |half_1 w_1| + |half_2 w_2| + |half_3 w_3| + |(disc_1
/// w_1, disc_2 w_2, disc_3 w_3)| from its centre.
struct SolidReach {
    float centre[3];
    float axis[3][3]; ///< [which axis][component]
    float half[3], disc[3], radius;
};

/// Four by two cells of a terrain, cell k in column k % 4 and row k / 4, by the heights of their corners; a hole's
/// heights are NaN. Cells beyond the last column or row have no width.
struct TerrainCells {
    float x[5], y[3], z[3][5];
    std::uint32_t falling; ///< one bit for each cell whose diagonal falls
    float margin;          ///< subtracted from the gaps, besides the rounding of heights
};

/// Blocks of a terrain: four by two, or two by four. A block lies between two heights, and between two planes with its
/// slopes.
struct TerrainBlocks {
    float x[5], y[5];                  ///< lines between blocks; beyond the last column and row, the last line again
    float half_x, half_y;              ///< half the size of a whole block
    alignas(32) float low[8], high[8]; ///< heights above `zero`; an empty block has low > high
    alignas(32) float slope_x[8], slope_y[8];
    alignas(32) float slab_low[8], slab_high[8]; ///< planes over the middle of the block, as if it were whole
    bool one_slope; ///< all blocks share their slopes; the planes are given over the middle of all of them
    bool wide;      ///< true: four by two
    float zero, margin;
};

struct SolidGapKernel {
    /// Returns one bit for each box whose distance from the solid may be at most `gap_limit`.
    /// @param line     another direction to bound the gaps along, away from the solid, and the solid's extent in it
    /// @param gaps     out: lower bounds of the distances after subtracting the margin; they ignore other rounding. The
    /// gap of a box is its distance from the solid's centre, less the solid's extent in that direction
    /// @param nearest  in and out, by lane: the smallest gap above `gap_limit`
    unsigned (*of_boxes)(const OpenBoxes& boxes, const SolidReach& solid, const BoxLine& line, float gap_limit,
                         float (&gaps)[8], float (&nearest)[8]);
    unsigned (*of_blocks)(const TerrainBlocks& blocks, const SolidReach& solid, const BoxLine& line, float gap_limit,
                          float (&gaps)[8], float (&nearest)[8]);
    /// The same for triangles: gaps[0] of the triangles with even numbers in the terrain, gaps[1] of the odd ones.
    /// @param apart  in and out: upper bound, except for rounding, of the distance of an edge from the solid's centre
    unsigned (*of_cells)(const TerrainCells& cells, const SolidReach& solid, const BoxLine& line, float gap_limit,
                         float (&gaps)[2][8], float (&nearest)[8], float& apart);
};

namespace baseline {
SolidGapKernel solid_gap_kernel();
}
namespace avx2 {
SolidGapKernel solid_gap_kernel();
}
namespace avx512 {
SolidGapKernel solid_gap_kernel();
}

} // namespace oncollide
