#pragma once

namespace oncollide {

/// One primitive as the octant test reads it: three points, and the unit normal spread over the fourth lanes (zero when
/// the triangle is too thin for one). A box is its low and high corner; its third point repeats the second.
struct alignas(16) Primitive {
    float point[3][4];
};

} // namespace oncollide
