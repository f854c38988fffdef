#include <oncollide/narrowphase/exact/triangle_gap.hpp>

#include <limits>

#include <oncollide/narrowphase/exact/wide_vector.hpp>

namespace oncollide {

namespace {

template <int N>
struct Gaps {
    const BinaryGrid& grid;
    std::array<WideVector<N, 3>, 9> apart; ///< the vector from each corner of a to each corner of b
    double widest = 0;
    Eigen::Vector3d widest_axis = Eigen::Vector3d::Zero();

    /// Takes the gap along the axis, if all of b is on one side of all of a.
    void add(const WideVector<2 * N, 3>& axis)
    {
        WideInteger<3 * N> least;
        int side = 0;
        for (const auto& between : apart) {
            const WideInteger<3 * N> along = dot(axis, between);
            const int sign = along.sign();
            if (!sign || sign == -side) return;
            const WideInteger<3 * N> size = along.magnitude();
            if (!side || (size - least).negative()) least = size;
            side = sign;
        }
        const int bits = bit_length(least);
        const int axis_bits = std::max({bit_length(axis[0]), bit_length(axis[1]), bit_length(axis[2])});
        Eigen::Vector3d scaled;
        for (int k = 0; k < 3; ++k) scaled[k] = scaled_down(axis[std::size_t(k)], axis_bits);
        const double units = scaled_down(least, bits) / scaled.norm() * (1 - 0x1p-45);
        const double gap = std::ldexp(units, bits - axis_bits + grid.exponent);
        // A smaller gap might have been rounded up.
        if (gap >= std::numeric_limits<double>::min() && gap > widest)
            widest = gap, widest_axis = side * scaled.normalized();
    }
};

} // namespace

double triangle_gap(const TrianglePoints& a, const TrianglePoints& b, Eigen::Vector3d* axis)
{
    const BinaryGrid grid = grid_of_points(a[0], a[1], a[2], b[0], b[1], b[2]);
    return with_limbs(grid, [&](auto limbs) {
        constexpr int n = decltype(limbs)::value;
        Gaps<n> gaps{grid, {}};
        std::array<WideVector<n, 3>, 3> of_a, of_b, axes{};
        for (std::size_t i = 0; i < 3; ++i) {
            axes[i][i].limb[0] = 1;
            of_a[i] = difference<n, 3>(grid, a[(i + 1) % 3], a[i]),
            of_b[i] = difference<n, 3>(grid, b[(i + 1) % 3], b[i]);
            for (std::size_t j = 0; j < 3; ++j) gaps.apart[3 * i + j] = difference<n, 3>(grid, b[j], a[i]);
        }
        gaps.add(cross<n>(of_a[0], of_a[1])), gaps.add(cross<n>(of_b[0], of_b[1]));
        for (std::size_t i = 0; i < 3; ++i) {
            gaps.add(cross<n>(axes[i], axes[(i + 1) % 3]));
            for (std::size_t j = 0; j < 3; ++j) {
                gaps.add(cross<n>(of_a[i], of_b[j]));
                gaps.add(cross<n>(of_a[i], axes[j])), gaps.add(cross<n>(of_b[i], axes[j]));
            }
        }
        if (axis) *axis = gaps.widest_axis;
        return gaps.widest;
    });
}

double least_possible_gap(const TrianglePoints& a, const TrianglePoints& b)
{
    // In units of the grid, edges are below 2^(bits + 1) and cross products of two edges below 2^(2 bits + 4). The gap
    // along a separating axis is an integer, so at least 1, divided by the axis's length.
    const BinaryGrid grid = grid_of_points(a[0], a[1], a[2], b[0], b[1], b[2]);
    const double gap = std::ldexp(1.0, grid.exponent - 2 * grid.bits - 4);
    return gap >= std::numeric_limits<double>::min() ? gap : 0;
}

} // namespace oncollide
