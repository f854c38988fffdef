// What boxes are fitted around triangles with, one implementation an instruction set. Plain data in, plain data out.
#pragma once
#include <cstddef>
#include <cstdint>

namespace oncollide {

/// Corners by corner, axis and triangle.
struct alignas(32) FourTriangles {
    double corners[3][3][4];
};

/// Sums over a surface, by the weights of its triangles.
struct SurfaceSums {
    double squares[6]; ///< xx, yy, zz, xy, xz, yz: twelve times the integrals over triangles of area 1
    double sum[3];     ///< thrice the centres
    double weight;
};

struct BoxFitKernel {
    /// The least and the most that corners show along each of three directions.
    void (*extent)(const FourTriangles* fours, std::size_t number, const double (&directions)[3][3], double (&low)[3],
                   double (&high)[3]);
    /// Of at most 2^14 triangles in the last of which the rest may be anything, on a grid of `scale` steps a metre on
    /// which the corners are at most 2^13 steps from the middle. All sums are of integers and below 2^53, so they are
    /// exact: the order of triangles and corners does not show, not even where all directions are alike.
    void (*sums)(const FourTriangles* fours, std::size_t triangles, const double (&middle)[3], double scale,
                 SurfaceSums& out);
    /// Of each of some numbers, how many others are less. Both readable and writable up to a multiple of 8.
    void (*count_less)(const float* numbers, std::size_t size, std::int32_t* less);
};

namespace baseline {
BoxFitKernel box_fit_kernel();
}
namespace avx2 {
BoxFitKernel box_fit_kernel();
}

} // namespace oncollide
