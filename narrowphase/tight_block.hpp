#pragma once
#include <cstdint>

namespace oncollide {

/// Tight bounds of the surface inside each octant of one cell, as columns by octant: one cache line. The surface in
/// octant k lies in a ball around the octant's centre moved by (x, y, z)[k] / 127 of its half-extents, of radius r[k] /
/// 255 of its sphere's, and between two planes across the direction (nx, ny, nz)[k], h[k] / 255 of that radius from the
/// ball's centre: a disc, where the surface is nearly flat.
struct alignas(64) TightBlock {
    std::int8_t x[8], y[8], z[8];
    std::uint8_t r[8];
    std::int8_t nx[8], ny[8], nz[8]; ///< never all 0; to be normalised
    std::uint8_t h[8];
};

/// One of them.
struct TightCell {
    std::int8_t x, y, z;
    std::uint8_t r;
    std::int8_t nx, ny, nz;
    std::uint8_t h;
};

/// The plain sphere around the cell.
constexpr TightCell plain_cell{0, 0, 0, 255, 0, 0, 127, 255};

} // namespace oncollide
