// Compiled once per instruction set; see oncollide_add_kernel.
#include <oncollide/base/simd/simd_vectors.hpp>
#include <oncollide/narrowphase/rays/tree/ray_kernel.hpp>

namespace oncollide::ONCOLLIDE_ISA {
namespace {

unsigned boxes(const RayNode& node, const RayLine& line, float last, float (&entry)[8])
{
    F32x8 enters = splat(0), leaves = splat(last);
#pragma GCC unroll 3
    for (int i = 0; i < 3; ++i) {
        const bool up = line.inverse[i] > 0;
        const F32x8 low = (load(node.low[i]) - line.from_more[i]) * line.inverse[i],
                    high = (load(node.high[i]) - line.from_less[i]) * line.inverse[i];
        enters = max(enters, up ? low : high), leaves = min(leaves, up ? high : low);
    }
    store(entry, enters);
    return bits(enters <= leaves);
}

/// The signs of the areas that the line makes with the three sides are equal if it meets the triangle.
RayHits triangles(const RayTriangles& row, const float (&point)[3], const float (&direction)[3], float limit)
{
    Vec corner[3];
#pragma GCC unroll 3
    for (int k = 0; k < 3; ++k)
        corner[k] = {widen(row.corner[k][0]) - point[0], widen(row.corner[k][1]) - point[1],
                     widen(row.corner[k][2]) - point[2]};
    const Vec along{splat(direction[0]), splat(direction[1]), splat(direction[2])};
    const F32x8 a = dot(along, cross(corner[1], corner[2])), b = dot(along, cross(corner[2], corner[0])),
                c = dot(along, cross(corner[0], corner[1]));
    const F32x8 least = min(a, min(b, c)), most = max(a, max(b, c));
    return {bits((least >= splat(-limit)) | (most <= splat(limit))),
            bits((least > splat(limit)) | (most < splat(-limit)))};
}

} // namespace

RayKernel ray_kernel()
{
    return {boxes, triangles};
}

} // namespace oncollide::ONCOLLIDE_ISA
