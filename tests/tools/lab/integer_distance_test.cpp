// The exact oracle of 'oncollide-lab hard' for terrains, compared with sampling.
#include <Eigen/Core>
#include <gtest/gtest.h>

#include <random>

#include "verify/oracle/integer_distance.hpp"

namespace oncollide::tools {
namespace {

using Vec = Eigen::Vector3d;

Vec at(const Place& p)
{
    return {double(p[0]), double(p[1]), double(p[2])};
}

/// The nearest points, by alternating projections between the segment and the triangle.
double nearest_sampled(const Place& from, const Place& to, const PlaceTriangle& t)
{
    const Vec p = at(from), q = at(to), a = at(t[0]), b = at(t[1]), c = at(t[2]);
    constexpr int steps = 40;
    double least = 1e300;
    for (int s = 0; s <= steps; ++s)
        for (int u = 0; u <= steps; ++u)
            for (int v = 0; u + v <= steps; ++v) {
                const Vec on = p + (q - p) * s / steps, in = a + (b - a) * u / steps + (c - a) * v / steps;
                least = std::min(least, (on - in).norm());
            }
    return least;
}

TEST(IntegerDistance, IsThatOfTheNearestPoints)
{
    std::mt19937 random(3);
    const auto number = [&](int most) { return std::uniform_int_distribution<int>(-most, most)(random); };
    int meet = 0;
    for (int k = 0; k < 400; ++k) {
        const int most = k % 2 ? 40 : 4; // on a coarse grid many cases are coplanar or collinear
        const auto place = [&] { return Place{number(most), number(most), number(most)}; };
        const PlaceTriangle t{place(), place(), place()};
        if ((at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0])).isZero(0)) continue;
        const Place from = place(), to = k % 3 ? place() : from;
        const SquareLength square = square_distance(from, to, t);
        const double sampled = nearest_sampled(from, to, t), length = double(square.length());
        EXPECT_LE(length, sampled + 1e-12) << k;
        EXPECT_GE(length, sampled - 0.15 * most) << k; // the step of the samples
        meet += square.compare(0) == 0;
        EXPECT_TRUE(square.compare(std::int64_t(length) + 1) < 0);
        EXPECT_FALSE(square < square);
    }
    EXPECT_GT(meet, 20);
    const PlaceTriangle flat{Place{0, 0, 0}, Place{10, 0, 0}, Place{0, 10, 0}};
    EXPECT_TRUE(square_distance({3, 3, 7}, {3, 3, 9}, flat).compare(7) == 0);
    EXPECT_TRUE(square_distance({13, -4, 0}, {13, -4, 0}, flat).compare(5) == 0);
    EXPECT_TRUE(square_distance({-1, -1, 1}, {1, 1, -1}, flat).compare(0) == 0);
    EXPECT_TRUE(square_distance({-5, 5, 3}, {5, -5, 3}, flat).compare(3) == 0);
}

} // namespace
} // namespace oncollide::tools
