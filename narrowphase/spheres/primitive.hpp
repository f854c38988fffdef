#pragma once

namespace oncollide {

/// One primitive in the form that the octant test reads: three points, and the unit normal in the fourth lanes (zero if
/// the triangle is too thin for one). A box is its low and high corner; its third point repeats the second.
struct alignas(16) Primitive {
    float point[3][4];
};

} // namespace oncollide
