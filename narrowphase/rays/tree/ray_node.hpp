#pragma once
#include <cstdint>

namespace oncollide {

/// Eight axis-aligned boxes around triangles of one mesh, relative to the tree's centre, rounded outward. Lanes past
/// the last box are empty: low is infinite, high minus infinity.
struct alignas(64) RayNode {
    float low[3][8], high[3][8];
    std::uint32_t child[8]; ///< as RayTree::Ref; 0: not grown yet. Other threads may set it
    std::uint32_t boxes;    ///< the node of the ObbTree whose boxes these are around; not for parts of few triangles
};
static_assert(sizeof(RayNode) == 256);

/// Up to eight triangles, quantised: the corners are centre + unit * corner, within 0.87 units. The last triangle
/// is repeated in the lanes past it.
struct alignas(64) RayTriangles {
    std::int16_t corner[3][3][8]; ///< [which corner][coordinate]
    float centre[3], unit;
    std::uint32_t triangle[8]; ///< numbers in the tree
};
static_assert(sizeof(RayTriangles) == 192);

/// The points from + t direction with t >= 0, in floats relative to the tree's centre.
struct RayLine {
    float inverse[3];                 ///< 1 / direction, at most 1e18
    float from_less[3], from_more[3]; ///< from, less and plus an error that exceeds all rounding of the box test
};

/// One bit for each triangle that a line may meet, and one for each whose inside it certainly crosses.
struct RayHits {
    unsigned possible, certain;
};

} // namespace oncollide
