// How far a convex solid is from boxes and from the cells of a terrain, one implementation an instruction set. Plain
// data in, plain data out.
#pragma once
#include <oncollide/narrowphase/obb/box_node.hpp>
#include <oncollide/narrowphase/obb/oriented_box_kernel.hpp>

namespace oncollide {

/// A convex solid, or one around it, in the frame of a hierarchy's boxes. Along u, of length 1 and with the parts w
/// along its axes, it reaches radius + |half_1 w_1| + |half_2 w_2| + |half_3 w_3| + |(disc_1 w_1, disc_2 w_2, disc_3
/// w_3)| from its centre at most.
struct SolidReach {
    float centre[3];
    float axis[3][3]; ///< [which axis][component]
    float half[3], disc[3], radius;
};

/// Four by two cells of a terrain, cell k in column k % 4 and row k / 4, by the heights of their corners: of a hole not
/// numbers. Cells beyond the last column or row are of no width.
struct TerrainCells {
    float x[5], y[3], z[3][5];
    std::uint32_t falling; ///< a bit for each cell whose diagonal falls
    float margin;          ///< taken off the gaps, besides what heights add
};

/// Blocks of a terrain: four by two, or else two by four of them. All of a block is between two heights, and between
/// two planes with its slopes.
struct TerrainBlocks {
    float x[5], y[5];                  ///< between blocks; beyond the last column and row these again
    float half_x, half_y;              ///< of a whole block
    alignas(32) float low[8], high[8]; ///< heights above `zero`; where nothing is, low > high
    alignas(32) float slope_x[8], slope_y[8];
    alignas(32) float slab_low[8], slab_high[8]; ///< of the planes, over the middle of the block were it whole, or
    bool one_slope;                              ///< over that of all blocks, which share their slopes
    bool wide;                                   ///< four by two?
    float zero, margin;
};

struct SolidGapKernel {
    /// One bit for each box that the solid may come as near to as `cutoff`.
    /// @param line     another direction in which it looks, from the solid, and how far in it the solid reaches
    /// @param gaps     out: lower bounds on the distances, the margin taken off, other rounding aside. A box shows its
    ///                 distance from the solid's centre, in the direction of which the solid reaches that much less far
    /// @param nearest  in and out, by lane: the smallest gap above `cutoff`
    unsigned (*of_boxes)(const OpenBoxes& boxes, const SolidReach& solid, const BoxLine& line, float cutoff,
                         float (&gaps)[8], float (&nearest)[8]);
    unsigned (*of_blocks)(const TerrainBlocks& blocks, const SolidReach& solid, const BoxLine& line, float cutoff,
                          float (&gaps)[8], float (&nearest)[8]);
    /// The same of triangles: first those of the cells with even numbers in the terrain, then those with odd ones.
    /// @param apart  in and out: not farther than this, but for rounding, is an edge from the solid's centre
    unsigned (*of_cells)(const TerrainCells& cells, const SolidReach& solid, const BoxLine& line, float cutoff,
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
