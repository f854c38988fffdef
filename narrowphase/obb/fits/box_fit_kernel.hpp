// Kernels for fitting boxes around triangles, one implementation per instruction set. Plain data in, plain data out.
#pragma once
#include <cstddef>
#include <cstdint>

namespace oncollide {

/// Indexed by corner, axis and triangle.
struct alignas(32) FourTriangles {
    double corners[3][3][4];
};

/// Sums over a surface, weighted by its triangles.
struct SurfaceSums {
    double squares[6]; ///< xx, yy, zz, xy, xz, yz: twelve times the integrals over triangles of area 1
    double sum[3];     ///< three times the centres
    double weight;
};

struct BoxFitKernel {
    /// The smallest and the largest projection of the corners onto each of three directions.
    void (*extent)(const FourTriangles* fours, std::size_t number, const double (&directions)[3][3], double (&low)[3],
                   double (&high)[3]);
    /// Sums over at most 2^14 triangles; unused lanes of the last four may hold anything. Coordinates are rounded to a
    /// grid of `scale` steps per metre, on which the corners are at most 2^13 steps from the middle. All sums are of
    /// integers and below 2^53, so they are exact: the result does not depend on the order of triangles and corners,
    /// even if the surface spreads equally in all directions.
    void (*sums)(const FourTriangles* fours, std::size_t triangles, const double (&middle)[3], double scale,
                 SurfaceSums& out);
    /// For each number, counts the numbers that are less. Both arrays must be accessible up to a multiple of 8
    /// elements.
    void (*count_less)(const float* numbers, std::size_t size, std::int32_t* less);
};

namespace baseline {
BoxFitKernel box_fit_kernel();
}
namespace avx2 {
BoxFitKernel box_fit_kernel();
}

} // namespace oncollide
