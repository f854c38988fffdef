// Winding number of closed surfaces around a point, in integers. Independent of the code under test, which follows a
// ray that touches no edge through a tree of boxes. Here the ray runs along x, and a point whose ray meets an edge is
// moved aside by an infinitesimal.
#include "truth/exact_inside.hpp"

#include "truth/integers.hpp"

namespace oncollide::oracle {
namespace {

/// The first of three signs that is not 0.
int first_sign(int a, int b, int c)
{
    return a ? a : b ? b : c;
}

/// The side of edge u to v on which the point (e, e^2) lies, in projection along x, for any small enough e > 0.
template <int N>
int side_of_edge(const Point<N>& u, const Point<N>& v)
{
    return first_sign((u[1] * v[2] - u[2] * v[1]).sign(), (u[2] - v[2]).sign(), (v[1] - u[1]).sign());
}

/// The triangle's contribution to the winding number around the origin, if the ray along x crosses it; nullopt if the
/// origin is on the triangle.
template <int N>
std::optional<int> winding_of(const std::array<Point<N>, 3>& t)
{
    const int side = side_of_edge<N>(t[0], t[1]);
    if (side == 0 || side != side_of_edge<N>(t[1], t[2]) || side != side_of_edge<N>(t[2], t[0])) return 0;
    const Int<N> volume = dot(t[0], cross(t[1], t[2]));
    if (volume.sign() == 0) return std::nullopt;
    return volume.sign() == side ? side : 0;
}

template <int N>
std::optional<int> winding_of(const TrianglePoints& t, const Eigen::Vector3d& point, int lowest)
{
    std::array<Point<N>, 3> from;
    for (std::size_t i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) from[i][k] = integer<Int<N>>(t[i][k], lowest) - integer<Int<N>>(point[k], lowest);
    return winding_of<N>(from);
}

} // namespace

std::optional<int> winding(std::size_t count, FunctionRef<TrianglePoints(std::size_t)> triangle,
                           const Eigen::Vector3d& point)
{
    int sum = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const TrianglePoints t = triangle(i);
        const auto beside = [&](int k) {
            const auto [least, most] = std::minmax({t[0][k], t[1][k], t[2][k]});
            return point[k] < least || point[k] > most;
        };
        if (beside(1) || beside(2) || point.x() > std::max({t[0].x(), t[1].x(), t[2].x()})) continue;
        Digits digits;
        digits.take(t);
        for (double x : point) digits.take(x);
        const int needed = 3 * (digits.count() + 1) + 4; // a sum of three products of three differences, doubled
        const std::optional<int> one = needed <= 256    ? winding_of<4>(t, point, digits.lowest)
                                       : needed <= 1024 ? winding_of<16>(t, point, digits.lowest)
                                                        : winding_of<100>(t, point, digits.lowest); // up to 6,301
        if (!one) return std::nullopt;
        sum += *one;
    }
    return sum;
}

std::optional<int> winding(std::span<const TrianglePoints> surface, const Eigen::Vector3d& point)
{
    return winding(
        surface.size(), [&](std::size_t i) { return surface[i]; }, point);
}

} // namespace oncollide::oracle
