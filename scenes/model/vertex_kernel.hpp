// Passes over the vertices of a mesh, compiled once per instruction set. Plain data in, plain data out.
#pragma once
#include <cstddef>

namespace oncollide {

struct VertexExtent {
    double low[3], high[3]; ///< bounds
    double moved[3];        ///< greatest differences to the vertices before, by axis
    bool finite;            ///< all coordinates are; else the rest means nothing
};

/// Vertices are x, y, z in turn.
struct VertexKernel {
    /// @param count  at least 1
    void (*extent)(const double* vertices, const double* before, std::size_t count, VertexExtent& out);
    /// The greatest squared distance of a vertex from the centre, added in the order of Eigen's squaredNorm(); 0
    /// without vertices.
    double (*radius2)(const double* vertices, std::size_t count, const double (&centre)[3]);
};

namespace baseline {
VertexKernel vertex_kernel();
}
namespace avx2 {
VertexKernel vertex_kernel();
}

} // namespace oncollide
