// The octant test's inner loop, one implementation per instruction set.
#pragma once
#include <cstdint>

#include <oncollide/narrowphase/spheres/primitive.hpp>

namespace oncollide {

/// A cell in the form that the octant tests of all backends use.
struct OctantCell {
    float centre[3]; ///< relative to the root's centre
    float half[3];   ///< half-extents of the cell
    float slack;     ///< RootCell::slack()
};

/// The triangles of a list, each with the octants of the list's cell that it enters.
struct TriangleSpan {
    const std::uint32_t* ids;  ///< null: every primitive
    const std::uint8_t* masks; ///< only triangles with bit `octant` take part
    std::uint32_t count;
    unsigned octant;
};

/// Writes the triangles that enter the cell and the octants that each enters. Both outputs need room for `count`.
/// Returns the number written.
using OctantTest = std::uint32_t(const Primitive* primitives, bool boxes, const TriangleSpan& triangles,
                                 const OctantCell& cell, std::uint32_t* ids, std::uint8_t* masks);

namespace baseline {
OctantTest* octant_test();
}
namespace avx2 {
OctantTest* octant_test();
}

} // namespace oncollide
