// Blocks and cells of a terrain against lines, one implementation per instruction set. Plain data in, plain data out.
#pragma once
#include <oncollide/narrowphase/obb/solid_gap_kernel.hpp>
#include <oncollide/narrowphase/rays/tree/ray_node.hpp>

namespace oncollide {

/// A line in floats, as blocks of a terrain need it.
struct TerrainLine {
    RayLine ray;
    float direction[3];
    float error; ///< of a point of the line, metres: exceeds all rounding of floats. `ray` is widened by it
};

/// The hits of the triangles with even numbers in the terrain, and of the odd ones; a bit for each cell.
struct CellHits {
    RayHits even, odd;
    float reach; ///< upper bound of the distance of the cells' corners from the line's point
};

struct TerrainRayKernel {
    /// One bit for each block that the line meets at t <= last, and possibly for others. Writes the lower bounds of t
    /// at which it enters these blocks; 0 if it begins inside.
    unsigned (*blocks)(const TerrainBlocks& blocks, const TerrainLine& line, float last, float (&entry)[8]);
    /// @param cells      relative to a point of the line
    /// @param direction  of the line; has length 1, or 0 for a point
    /// @param error      of the point, metres
    CellHits (*cells)(const TerrainCells& cells, const float (&direction)[3], float error);
};

namespace baseline {
TerrainRayKernel terrain_ray_kernel();
}
namespace avx2 {
TerrainRayKernel terrain_ray_kernel();
}

} // namespace oncollide
