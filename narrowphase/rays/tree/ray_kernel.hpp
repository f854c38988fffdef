// Boxes and triangles of a RayTree against lines, one implementation per instruction set. Plain data in, plain data
// out.
#pragma once
#include <oncollide/narrowphase/rays/tree/ray_node.hpp>

namespace oncollide {

struct RayKernel {
    /// One bit for each box that the line meets at t <= last, and possibly for others. Writes the lower bounds of t at
    /// which it enters these boxes; 0 if it begins inside.
    unsigned (*boxes)(const RayNode& node, const RayLine& line, float last, float (&entry)[8]);
    /// @param point      a point of the line, relative to the centre of the triangles, in their units
    /// @param direction  of the line; has length 1
    /// @param limit      greater than the error of twice the area that the line makes with a side of a triangle
    RayHits (*triangles)(const RayTriangles& row, const float (&point)[3], const float (&direction)[3], float limit);
};

namespace baseline {
RayKernel ray_kernel();
}
namespace avx2 {
RayKernel ray_kernel();
}

} // namespace oncollide
