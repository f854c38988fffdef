// Tests of the triangles around vertices, one implementation per instruction set. Plain data in, plain data out.
#pragma once
#include <cstdint>

namespace oncollide {

/// The triangles at each vertex v, numbers begin[v] to begin[v + 1]: each goes from an edge to first[i] to an edge to
/// second[i]. Both columns have room for 16 more.
struct FansOfVertices {
    const double* vertices; ///< x y z
    const std::uint32_t *begin, *first, *second;
};

/// Sets spread[v] for `from` <= v < `to`, see spread_fans().
using SpreadFans = void(const FansOfVertices& fans, std::uint32_t from, std::uint32_t to, std::uint8_t* spread);

namespace baseline {
SpreadFans* spread_fans_kernel();
}
namespace avx2 {
SpreadFans* spread_fans_kernel();
}
namespace avx512 {
SpreadFans* spread_fans_kernel();
}

} // namespace oncollide
