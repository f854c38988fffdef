// Contact of two triangles by linear programming in integers: they meet if sum a_i p_i = sum b_j q_j has a solution
// with a, b >= 0 and sum a = sum b = 1. Without orientations and case distinctions: independent of the code under test,
// and equally valid for segments, points and coplanar triangles.
#include "truth/exact_oracle.hpp"

#include "truth/integers.hpp"

namespace oncollide::oracle {
namespace {

/// True if M x = b has a solution with x >= 0. Rows are [M | b]. Phase one of the simplex method by Bland's rule, with
/// fraction-free pivots (Edmonds): every entry stays a minor of the input.
template <int N, std::size_t Rows, std::size_t Columns>
bool feasible(std::array<std::array<Int<N>, Columns>, Rows> m)
{
    constexpr std::size_t b = Columns - 1;
    std::array<Int<N>, Columns> goal{}; // remaining sum of the artificial variables
    for (auto& row : m) {
        if (row[b].sign() < 0)
            for (auto& x : row) x = -x;
        for (std::size_t j = 0; j < Columns; ++j) goal[j] += row[j];
    }
    std::array<std::size_t, Rows> basis;
    for (std::size_t i = 0; i < Rows; ++i) basis[i] = Columns + i;
    Int<N> last(1);
    while (goal[b].sign() > 0) {
        std::size_t c = 0, r = Rows;
        while (c < b && goal[c].sign() <= 0) ++c;
        if (c == b) return false;
        for (std::size_t i = 0; i < Rows; ++i) {
            if (m[i][c].sign() <= 0) continue;
            const int order = r == Rows ? -1 : (m[i][b] * m[r][c] - m[r][b] * m[i][c]).sign();
            if (order < 0 || (order == 0 && basis[i] < basis[r])) r = i;
        }
        const auto pivot_row = m[r];
        const auto eliminate = [&](auto& row) {
            const Int<N> factor = row[c];
            for (std::size_t j = 0; j < Columns; ++j) row[j] = (row[j] * pivot_row[c] - factor * pivot_row[j]) / last;
        };
        for (std::size_t i = 0; i < Rows; ++i)
            if (i != r) eliminate(m[i]);
        eliminate(goal);
        basis[r] = c;
        last = pivot_row[c];
    }
    return true;
}

template <int N>
TriangleContact contact(const std::array<Point<N>, 3>& p, const std::array<Point<N>, 3>& q)
{
    std::array<std::array<Int<N>, 7>, 5> meet{};
    for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t i = 0; i < 3; ++i) meet[k][i] = p[i][k], meet[k][3 + i] = -q[i][k];
        meet[3][k] = meet[3][6] = meet[4][3 + k] = meet[4][6] = Int<N>(1);
    }
    if (!feasible<N>(meet)) return TriangleContact::separate;

    // Crossing: a solution with a, b > 0 (at least 1 when scaled), and edges that span 3D space.
    std::array<std::array<Int<N>, 7>, 4> inside{};
    for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t i = 0; i < 6; ++i) {
            inside[k][i] = meet[k][i], inside[k][6] = inside[k][6] - meet[k][i];
            inside[3][i] = Int<N>(i < 3 ? 1 : -1);
        }
    if (!feasible<N>(inside)) return TriangleContact::touching;
    const std::array<Point<N>, 4> edge{p[1] - p[0], p[2] - p[0], q[1] - q[0], q[2] - q[0]};
    for (std::size_t left_out = 0; left_out < 4; ++left_out) {
        const auto &u = edge[left_out == 0 ? 1 : 0], &v = edge[left_out < 2 ? 2 : 1], &w = edge[left_out == 3 ? 2 : 3];
        if (dot(cross(u, v), w).sign()) return TriangleContact::crossing;
    }
    return TriangleContact::touching;
}

template <int N>
TriangleContact contact(const TrianglePoints& a, const TrianglePoints& b, int lowest)
{
    std::array<Point<N>, 3> p, q;
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) {
            const Int<N> origin = integer<Int<N>>(a[0][k], lowest);
            p[i][k] = integer<Int<N>>(a[i][k], lowest) - origin, q[i][k] = integer<Int<N>>(b[i][k], lowest) - origin;
        }
    return contact<N>(p, q);
}

} // namespace

TriangleContact contact(const TrianglePoints& a, const TrianglePoints& b)
{
    Digits digits;
    digits.take(a), digits.take(b);
    const int lowest = digits.lowest;
    // An entry is a minor with three rows of differences: below 5! 2^(3 (bits + 1)), 8 times that in the last column.
    // The largest numbers are differences of products of two.
    const int needed = 6 * digits.count() + 24;
    if (needed <= 256) return contact<4>(a, b, lowest);
    if (needed <= 512) return contact<8>(a, b, lowest);
    if (needed <= 1024) return contact<16>(a, b, lowest);
    if (needed <= 4096) return contact<64>(a, b, lowest);
    return contact<200>(a, b, lowest); // 2,098 bits need 12,610
}

} // namespace oncollide::oracle
