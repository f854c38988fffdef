// Triangles against triangles, one implementation an instruction set. Plain data in, plain data out.
#pragma once
#include <cstdint>

namespace oncollide {

/// Boxes of eight triangles, closed. Lanes without a triangle hold NaN and overlap nothing.
struct BoxBlock {
    alignas(32) float lo[3][8], hi[3][8];
};

/// The box of one triangle, closed.
struct FloatBox {
    float lo[3], hi[3];
};

/// Triangles a against triangles b. Boxes of both are rounded alike, so that none that touch are apart. Triangle i has
/// its 9 coordinates at corners + 9 i; the box of b's triangle i is lane i % 8 of block i / 8.
struct TrianglesToPair {
    const FloatBox* boxes_a;
    const double* corners_a;
    std::uint32_t count_a;
    const BoxBlock* blocks_b;
    const double* corners_b;
    std::uint32_t blocks;
};

/// Two triangles that meet: certainly, or possibly when the filter could not tell.
struct FoundPair {
    std::uint32_t a, b;
    bool certain;
};

/// Where to go on: block `block` of b against triangle `a`.
struct PairCursor {
    std::uint32_t a = 0, block = 0;
};

/// Pairs that meet or may meet, ascending, from `cursor` on, to `out`; all others are certainly separate. Stops, and
/// sets the cursor, when fewer than 16 of the `room` places are left, or, with `first_only`, soon after a pair that
/// certainly meets. Returns how many were written; cursor.a is count_a when all is done.
using FindPairs = std::uint32_t(const TrianglesToPair& lists, PairCursor& cursor, bool first_only, FoundPair* out,
                                std::uint32_t room);

namespace baseline {
FindPairs* find_pairs();
}
namespace avx2 {
FindPairs* find_pairs();
}
namespace avx512 {
FindPairs* find_pairs();
}

} // namespace oncollide
