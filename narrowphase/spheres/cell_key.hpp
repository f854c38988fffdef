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
    std::array<std::int32_t, 3> centre{};
    for (int level = 0, depth = level_of(cell); level < depth; ++level)
        for (std::size_t axis = 0; axis < 3; ++axis)
            centre[axis] = 2 * centre[axis] + (octant_at(cell, level) >> axis & 1 ? 1 : -1);
    return centre;
}

} // namespace oncollide
