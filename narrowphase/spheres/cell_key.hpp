#pragma once
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace oncollide {

/// Names one cell of an octree: a leading 1, then one octal digit per level, the octant. Root: 1. Octant k lies on the
/// high side of axis a if bit a of k is set. An integer, so that two paths to the same cell agree.
using CellKey = std::uint64_t;

constexpr CellKey root_cell = 1;
constexpr int deepest_level = 16; ///< cells below it would be as small as the rounding of the float copies

constexpr CellKey child_cell(CellKey cell, unsigned octant)
{
    return cell << 3 | octant;
}

constexpr CellKey parent_cell(CellKey cell)
{
    return cell >> 3;
}

constexpr unsigned octant_of(CellKey cell)
{
    return cell & 7;
}

/// 0 for the root.
constexpr int level_of(CellKey cell)
{
    return (static_cast<int>(std::bit_width(cell)) - 1) / 3;
}

/// The octant on the path to `cell` between `level` and level + 1.
constexpr unsigned octant_at(CellKey cell, int level)
{
    return cell >> 3 * (level_of(cell) - level - 1) & 7;
}

/// The cell's centre along each axis, in half-extents of the cell, from the root's centre: odd integers.
constexpr std::array<std::int32_t, 3> centre_of(CellKey cell)
{
    const int depth = level_of(cell);
    const auto centre = [&](int axis) {
        CellKey x = (cell ^ CellKey{1} << 3 * depth) >> axis & 0x1249249249249; // every third bit, moved together
        x = (x | x >> 2) & 0x10c30c30c30c3, x = (x | x >> 4) & 0x100f00f00f00f;
        x = (x | x >> 8) & 0x1f0000ff0000ff, x = (x | x >> 16) & 0xffff;
        return 2 * static_cast<std::int32_t>(x) + 1 - (1 << depth);
    };
    return {centre(0), centre(1), centre(2)};
}

} // namespace oncollide
