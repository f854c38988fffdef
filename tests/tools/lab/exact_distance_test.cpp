// The exact distance of triangles, compared with sampling.
#include <Eigen/Core>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "verify/oracle/exact_distance.hpp"

namespace oncollide::tools {
namespace {

using Vec = Eigen::Vector3d;

/// The nearest points of a segment and a triangle, on a grid of each.
double nearest_sampled(const Vec& p, const Vec& q, const TrianglePoints& t)
{
    constexpr int steps = 40;
    double least = 1e300;
    for (int s = 0; s <= steps; ++s)
        for (int u = 0; u <= steps; ++u)
            for (int v = 0; u + v <= steps; ++v) {
                const Vec on = p + (q - p) * s / steps,
                          in = t[0] + (t[1] - t[0]) * u / steps + (t[2] - t[0]) * v / steps;
                least = std::min(least, (on - in).norm());
            }
    return least;
}

TEST(ExactDistance, OfASegmentIsThatOfTheNearestPoints)
{
    std::mt19937 random(3);
    const auto number = [&](int most) { return std::uniform_int_distribution<int>(-most, most)(random); };
    int meet = 0;
    for (int k = 0; k < 400; ++k) {
        const int most = k % 2 ? 40 : 4; // on a coarse grid many cases are coplanar or collinear
        const auto place = [&] { return Vec(number(most), number(most), number(most)); };
        const TrianglePoints t{place(), place(), place()}, other{place(), place(), place()};
        const Vec from = place(), to = k % 3 ? place() : from;
        const oracle::ExactDistance distance({from, to, to}, t);
        const double sampled = nearest_sampled(from, to, t), length = double(distance.value());
        EXPECT_LE(length, sampled + 1e-12) << k;
        EXPECT_GE(length, sampled - 0.15 * most) << k; // the step of the samples
        meet += distance.compare(0) == 0;
        EXPECT_LT(distance.compare(std::floor(length) + 1), 0);
        EXPECT_FALSE(distance < distance);
        const oracle::ExactDistance second({from, to, to}, other),
            least = oracle::least_distance({from, to, to}, std::array{t, other});
        EXPECT_EQ(least.value(), std::min(distance.value(), second.value())) << k;
    }
    EXPECT_GT(meet, 20);
    const TrianglePoints flat{Vec(0, 0, 0), Vec(10, 0, 0), Vec(0, 10, 0)};
    const auto compare = [&](const Vec& from, const Vec& to, double length) {
        return oracle::ExactDistance({from, to, to}, flat).compare(length);
    };
    EXPECT_EQ(compare({3, 3, 7}, {3, 3, 9}, 7), 0);
    EXPECT_EQ(compare({13, -4, 0}, {13, -4, 0}, 5), 0);
    EXPECT_EQ(compare({-1, -1, 1}, {1, 1, -1}, 0), 0);
    EXPECT_EQ(compare({-5, 5, 3}, {5, -5, 3}, 3), 0);
}

} // namespace
} // namespace oncollide::tools
