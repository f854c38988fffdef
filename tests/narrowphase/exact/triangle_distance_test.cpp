#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/exact/triangle_distance.hpp>

namespace oncollide::triangle_distance_test {
namespace {

using Eigen::Vector3d;

TEST(TriangleDistance, IsThatOfTheNearestPoints)
{
    const TrianglePoints floor{Vector3d(0, 0, 0), Vector3d(4, 0, 0), Vector3d(0, 4, 0)};
    const auto to = [&](const TrianglePoints& t) {
        EXPECT_DOUBLE_EQ(triangle_distance(floor, t), triangle_distance(t, floor));
        EXPECT_LE(triangle_distance(floor, t), corner_distance(floor, t) * (1 + 1e-15));
        return triangle_distance(floor, t);
    };
    EXPECT_DOUBLE_EQ(to({Vector3d(1, 1, 0.5), Vector3d(1, 1, 3), Vector3d(2, 1, 3)}), 0.5) << "corner over face";
    EXPECT_DOUBLE_EQ(to({Vector3d(1, 1, 2), Vector3d(2, 1, 2), Vector3d(1, 2, 2)}), 2) << "parallel faces";
    EXPECT_DOUBLE_EQ(to({Vector3d(-1, -1, 0), Vector3d(-2, -1, 0), Vector3d(-1, -2, 0)}), std::sqrt(2.0)) << "corners";
    EXPECT_DOUBLE_EQ(to({Vector3d(2, -1, -3), Vector3d(2, -1, 3), Vector3d(2, -5, 0)}), 1) << "edges across";
    EXPECT_DOUBLE_EQ(to({Vector3d(1, -2, 0), Vector3d(3, -2, 0), Vector3d(2, -5, 0)}), 2) << "parallel edges";
    EXPECT_DOUBLE_EQ(to({Vector3d(1, 1, 7), Vector3d(1, 1, 7), Vector3d(1, 1, 7)}), 7) << "a point";
    EXPECT_DOUBLE_EQ(to({Vector3d(-3, -1, 4), Vector3d(5, -1, 4), Vector3d(5, -1, 4)}), std::sqrt(17.0)) << "a segment";

    // No two sampled points are nearer, and by descent some are as near.
    for (std::uint64_t seed = 0; seed < 300; ++seed) {
        TrianglePoints a, b;
        for (std::uint64_t k = 0; k < 3; ++k)
            for (std::uint64_t i = 0; i < 3; ++i)
                a[k][int(i)] = u01(seed, 11, 3 * k + i), b[k][int(i)] = u01(seed, 12, 3 * k + i) + (i == 2 ? 0.8 : 0);
        if (triangles_meet(a, b)) continue;
        const double distance = triangle_distance(a, b);
        // Descends in the convex set of differences by steps towards the best corner (Frank and Wolfe).
        Vector3d d = a[0] - b[0];
        for (int step = 0; step < 3000; ++step) {
            Vector3d best = a[0] - b[0];
            for (const Vector3d& p : a)
                for (const Vector3d& q : b)
                    if (d.dot(p - q) < d.dot(best)) best = p - q;
            const Vector3d along = best - d;
            if (!(along.squaredNorm() > 0)) break;
            d += std::clamp(-d.dot(along) / along.squaredNorm(), 0.0, 1.0) * along;
        }
        EXPECT_LE(distance, d.norm() + 1e-12);
        EXPECT_NEAR(distance, d.norm(), 0.01);
    }
}

TEST(TriangleDistance, OfAPointIsThatOfATriangleShrunkToThePoint)
{
    for (std::uint64_t seed = 0; seed < 2000; ++seed) {
        TrianglePoints t;
        for (std::uint64_t k = 0; k < 3; ++k)
            for (std::uint64_t i = 0; i < 3; ++i) t[k][int(i)] = u01(seed, 21, 3 * k + i);
        if (seed % 8 == 0) t[2] = t[seed % 3 == 0 ? 1 : 0]; // a segment
        if (seed % 8 == 1) t[1] = t[2] = t[0];              // a point
        if (seed % 8 == 2) t[1] = 0.5 * (t[0] + t[2]);      // its corners are on one line
        const Vector3d p(3 * u01(seed, 22, 0) - 1, 3 * u01(seed, 22, 1) - 1, 3 * u01(seed, 22, 2) - 1);
        const double distance = (nearest_on(t, p).at - p).norm(), expected = triangle_distance({p, p, p}, t);
        EXPECT_GE(distance, expected - 1e-7) << seed;
        EXPECT_LE(distance, (seed % 8 == 2 ? corner_distance({p, p, p}, t) : expected) + 1e-7) << seed;
    }
}

} // namespace
} // namespace oncollide::triangle_distance_test
