// Vectors of integers on a common grid, for the exact evaluations. with_limbs() chooses their width.
#pragma once
#include <algorithm>
#include <array>

#include <Eigen/Core>

#include <oncollide/base/numbers/wide_integer.hpp>

namespace oncollide {

template <int N, int D>
using WideVector = std::array<WideInteger<N>, D>;

/// a - b.
template <int N, int D>
WideVector<N, D> difference(const BinaryGrid& grid, const Eigen::Matrix<double, D, 1>& a,
                            const Eigen::Matrix<double, D, 1>& b)
{
    WideVector<N, D> v;
    for (int k = 0; k < D; ++k) v[k] = on_grid<N>(a[k], grid) - on_grid<N>(b[k], grid);
    return v;
}

/// a d - b c.
template <int N>
WideInteger<2 * N> minor_of(const WideInteger<N>& a, const WideInteger<N>& b, const WideInteger<N>& c,
                            const WideInteger<N>& d)
{
    return a * d - b * c;
}

template <int N>
WideVector<2 * N, 3> cross(const WideVector<N, 3>& u, const WideVector<N, 3>& v)
{
    return {minor_of(u[1], u[2], v[1], v[2]), minor_of(u[2], u[0], v[2], v[0]), minor_of(u[0], u[1], v[0], v[1])};
}

template <int A, int B>
WideInteger<A + B> dot(const WideVector<A, 3>& n, const WideVector<B, 3>& v)
{
    return n[0] * v[0] + n[1] * v[1] + n[2] * v[2];
}

/// The common grid of all coordinates of the points.
template <class... Points>
BinaryGrid grid_of_points(const Points&... points)
{
    std::array<double, (Points::RowsAtCompileTime + ...)> all;
    double* end = all.data();
    ((end = std::copy(points.data(), points.data() + points.size(), end)), ...);
    return grid_of(all);
}

} // namespace oncollide
