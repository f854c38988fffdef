#include <oncollide/narrowphase/pairs/manifolds/points/point_hull.hpp>

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>

namespace oncollide::point_hull_test {
namespace {

using Eigen::Vector3d;

std::vector<ManifoldPoint> at(const std::vector<Vector3d>& places)
{
    std::vector<ManifoldPoint> points;
    const Vector3d half(0, 0, 0.5); // the middle counts
    for (const Vector3d& p : places) points.push_back({p + half, p - half, 1, 0, 0, 0, Vector3d::UnitZ()});
    return points;
}

Vector3d random_vector(std::uint64_t seed, std::uint64_t k)
{
    return {2 * u01(seed, k, 0) - 1, 2 * u01(seed, k, 1) - 1, 2 * u01(seed, k, 2) - 1};
}

TEST(PointHull, MeasuresToPointsSidesAndFaces)
{
    const auto square = at({{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}});
    const PointHull hull(square);
    EXPECT_EQ(hull.distance2({1, 0.5, 3}), 9) << "above a face";
    EXPECT_EQ(hull.distance2({1, -2, 0}), 4) << "beside a side";
    EXPECT_EQ(hull.distance2({3, 3, 1}), 3) << "beyond a corner";
    EXPECT_EQ(hull.distance2({0.5, 1.5, 0}), 0);
    const auto all = std::span<const ManifoldPoint>(square);
    const PointHull side(all.first(2));
    EXPECT_EQ(side.distance2({1, 2, 0}), 4);
    EXPECT_EQ(side.distance2({-1, 0, 0}), 1);
    const PointHull point(all.first(1));
    EXPECT_EQ(point.distance2({1, 2, 2}), 9);
    EXPECT_EQ(PointHull({}).distance2({0, 0, 0}), std::numeric_limits<double>::infinity());
}

TEST(PointHull, CoincidentPointsAreOne)
{
    const PointHull hull(at({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}));
    EXPECT_EQ(hull.distance2({1, 1, 3}), 4);
}

TEST(PointHull, HoldsAllMixturesOfPointsInAPlane)
{
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        const std::size_t count = 1 + seed % 9; // of few points all triangles, of more a fan
        const Vector3d u = random_vector(seed, 100), v = random_vector(seed, 101), from = random_vector(seed, 102);
        std::vector<Vector3d> places;
        for (std::size_t i = 0; i < count; ++i)
            places.push_back(from + (2 * u01(seed, i, 3) - 1) * u + (2 * u01(seed, i, 4) - 1) * v);
        const PointHull hull(at(places));
        for (std::uint64_t k = 0; k < 20; ++k) {
            Vector3d sum = Vector3d::Zero();
            double weights = 0;
            for (std::size_t i = 0; i < count; ++i) {
                const double w = std::pow(u01(seed, i, 10 + k), 4);
                sum += w * places[i], weights += w;
            }
            EXPECT_LT(hull.distance2(sum / weights), 1e-28) << seed;
        }
    }
}

TEST(PointHull, IsNoNearerThanAPlaneBetween)
{
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        std::vector<Vector3d> places;
        for (std::uint64_t i = 0; i < 1 + seed % 9; ++i) places.push_back(random_vector(seed, i));
        const PointHull hull(at(places));
        const Vector3d p = 3 * random_vector(seed, 50);
        const double distance = std::sqrt(hull.distance2(p));
        for (std::uint64_t k = 0; k < 40; ++k) {
            const Vector3d n = random_vector(seed, 60 + k).normalized();
            double gap = std::numeric_limits<double>::infinity();
            for (const Vector3d& q : places) gap = std::min(gap, n.dot(p - q));
            EXPECT_GE(distance, gap - 1e-12) << seed;
        }
    }
}

TEST(PointHull, StopsWhereTheDistanceIsKnownToBeSmallEnough)
{
    const PointHull hull(at({{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}}));
    EXPECT_LE(hull.distance2({1, 1, 1}, 100), 100);
    EXPECT_EQ(hull.distance2({1, 1, 1}, 1), 1);
    EXPECT_EQ(hull.distance2({1, 1, 5}, 3), 25) << "more than enough is measured to the end";
}

TEST(PointHull, MostLostIsTheFarthestThatIsLeftOut)
{
    const auto points = at({{0, 0, 0}, {2, 0, 0}, {1, 3, 0}, {1, 1, 0}});
    const auto all = std::span<const ManifoldPoint>(points);
    EXPECT_NEAR(most_lost(all.first(2), all.subspan(2)), 3, 1e-11);
    EXPECT_GE(most_lost(all.first(2), all.subspan(2)), 3);
    EXPECT_EQ(most_lost(all.first(3), all.subspan(3)), 0);
    EXPECT_EQ(most_lost({}, all), 0);
}

} // namespace
} // namespace oncollide::point_hull_test
