// One triangle against many, one implementation an instruction set. Plain data in, plain data out.
#pragma once
#include <cstdint>

namespace oncollide {

/// Boxes of eight triangles, rounded outward. Lanes without a triangle hold NaN and overlap nothing.
struct BoxBlock {
    alignas(32) float lo[3][8], hi[3][8];
};

struct TriangleQuery {
    const double* corners; ///< 9 coordinates
    float lo[3], hi[3];    ///< its box, rounded outward, in the blocks' frame
};

/// Triangles of blocks [begin, end) that meet the query certainly, or may meet it, ascending, to `out` (room for 8 a
/// block): twice the number of the triangle, plus 1 when the filter could not tell. All others are certainly separate.
/// Triangle i is lane i % 8 of block i / 8; its 9 coordinates are at corners + 9 i.
/// @param first_only  stop soon after a triangle that certainly meets
/// Returns how many were written.
using MeetingTriangles = std::uint32_t(const TriangleQuery& query, const BoxBlock* blocks, const double* corners,
                                       std::uint32_t begin, std::uint32_t end, bool first_only, std::uint32_t* out);

namespace baseline {
MeetingTriangles* meeting_triangles();
}
namespace avx2 {
MeetingTriangles* meeting_triangles();
}
namespace avx512 {
MeetingTriangles* meeting_triangles();
}

} // namespace oncollide
