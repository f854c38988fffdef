// Blocks and cells of a terrain in eight lanes, for kernel files only, after simd.hpp; like it, all code here is in the
// kernel's own namespace.
#include <oncollide/narrowphase/obb/solid_gap_kernel.hpp>

namespace oncollide::ONCOLLIDE_ISA {
namespace {

/// The lines before and after the columns and rows of eight blocks or cells: [0] along x, [1] along y.
struct TerrainLanes {
    F32x8 from[2], to[2];
};

/// Four by two of them, after the first lines of x and y.
inline TerrainLanes four_by_two(const float* x, const float* y)
{
    return {
        {F32x8{x[0], x[1], x[2], x[3], x[0], x[1], x[2], x[3]}, F32x8{y[0], y[0], y[0], y[0], y[1], y[1], y[1], y[1]}},
        {F32x8{x[1], x[2], x[3], x[4], x[1], x[2], x[3], x[4]}, F32x8{y[1], y[1], y[1], y[1], y[2], y[2], y[2], y[2]}}};
}
inline TerrainLanes lanes_of(const TerrainBlocks& blocks)
{
    const float(&x)[5] = blocks.x, (&y)[5] = blocks.y;
    if (blocks.wide) return four_by_two(x, y);
    return {
        {F32x8{x[0], x[1], x[0], x[1], x[0], x[1], x[0], x[1]}, F32x8{y[0], y[0], y[1], y[1], y[2], y[2], y[3], y[3]}},
        {F32x8{x[1], x[2], x[1], x[2], x[1], x[2], x[1], x[2]}, F32x8{y[1], y[1], y[2], y[2], y[3], y[3], y[4], y[4]}}};
}
/// The heights of the cells' corners in column i and row j, 0 or 1.
inline F32x8 heights_of(const TerrainCells& cells, int i, int j)
{
    const float *const low = cells.z[j] + i, *const high = cells.z[j + 1] + i;
    return F32x8{low[0], low[1], low[2], low[3], high[0], high[1], high[2], high[3]};
}
/// The cells whose diagonal falls.
inline I32x8 falling(const TerrainCells& cells)
{
    constexpr I32x8 bit{1, 2, 4, 8, 16, 32, 64, 128};
    return (bit & static_cast<std::int32_t>(cells.falling)) != 0;
}

} // namespace
} // namespace oncollide::ONCOLLIDE_ISA
