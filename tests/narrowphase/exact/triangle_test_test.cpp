#include <gtest/gtest.h>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/exact/triangle_distance.hpp>
#include <oncollide/narrowphase/exact/triangle_gap.hpp>
#include <oncollide/narrowphase/exact/triangle_test.hpp>

#include "truth/exact_oracle.hpp"
#include "verify/cases/triangle_families.hpp"

namespace oncollide {
namespace {

/// The longest edge of the two triangles or between them.
double extent(const TwoTriangles& pair)
{
    double most = 0;
    for (const Eigen::Vector3d& p : pair.first)
        for (const TrianglePoints* t : {&pair.first, &pair.second})
            for (const Eigen::Vector3d& q : *t) most = std::max(most, (p - q).cwiseAbs().maxCoeff());
    return most;
}

/// Expects a gap exactly for the pairs that the oracle separates, and no gap wider than the distance.
void check_gaps(const std::vector<TwoTriangles>& pairs)
{
    for (const TwoTriangles& pair : pairs) {
        const double gap = triangle_gap(pair.first, pair.second);
        EXPECT_EQ(gap > 0, oracle::contact(pair.first, pair.second) == TriangleContact::separate) << shown(pair);
        if (gap > 0) {
            EXPECT_GT(least_possible_gap(pair.first, pair.second), 0) << shown(pair);
            EXPECT_LE(least_possible_gap(pair.first, pair.second), gap) << shown(pair);
            const double rounding = 0x1p-38 * extent(pair) + 0x1p-48 * pair.first[0].norm();
            EXPECT_LE(gap, triangle_distance(pair.first, pair.second) + rounding) << shown(pair);
        }
    }
}

/// Counts by TriangleContact; a failure for each result that differs from the oracle's.
std::array<int, 3> check(const std::vector<TwoTriangles>& pairs)
{
    std::array<int, 3> count{};
    for (const TwoTriangles& pair : pairs) {
        const TriangleContact truth = oracle::contact(pair.first, pair.second);
        EXPECT_EQ(static_cast<int>(triangle_contact(pair.first, pair.second)), static_cast<int>(truth)) << shown(pair);
        EXPECT_EQ(triangles_meet(pair.first, pair.second), truth != TriangleContact::separate) << shown(pair);
        ++count[static_cast<int>(truth)];
    }
    return count;
}

class EveryFamily : public testing::TestWithParam<TriangleFamily> {
protected:
    std::vector<TwoTriangles> pairs(int count, std::uint64_t seed) const
    {
        GridPoints random(seed);
        std::vector<TwoTriangles> all;
        for (int i = 0; i < count; ++i) all.push_back(GetParam().make(random));
        return all;
    }
};

std::vector<TwoTriangles> all_moved(std::vector<TwoTriangles> pairs, double scale, double offset)
{
    GridPoints random(5);
    for (TwoTriangles& pair : pairs) pair = moved(pair, scale * random.rotation(), offset * random.rotation().col(0));
    return pairs;
}

TEST_P(EveryFamily, IsAnsweredAsByTheOracle)
{
    const std::array<int, 3> count = check(pairs(3000, 1));
    EXPECT_GT(count[0] + count[1], 100);
    RecordProperty("separate", count[0]), RecordProperty("touching", count[1]), RecordProperty("crossing", count[2]);
}

TEST_P(EveryFamily, IsAnsweredAsByTheOracleWhenTurnedAndRounded)
{
    check(all_moved(pairs(1500, 2), 1, 0));
}

TEST_P(EveryFamily, IsAnsweredAsByTheOracleAtEveryScaleAndOffset)
{
    const std::vector<TwoTriangles> some = pairs(150, 3);
    for (double scale : {1e-15, 1e-9, 1e-3, 1e3})
        for (double offset : {0.0, 1.0, 1e8}) check(all_moved(some, scale, offset));
}

TEST_P(EveryFamily, DoesNotDependOnOrder)
{
    std::vector<TwoTriangles> some = pairs(60, 4);
    for (const TwoTriangles& pair : all_moved(some, 1, 0)) some.push_back(pair);
    constexpr int orders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    const auto reordered = [&](const TrianglePoints& t, const int o[3]) {
        return TrianglePoints{t[o[0]], t[o[1]], t[o[2]]};
    };
    for (const auto& [a, b] : some)
        for (const auto& o : orders)
            for (const auto& q : orders) {
                const TrianglePoints x = reordered(a, o), y = reordered(b, q);
                ASSERT_EQ(triangle_contact(x, y), triangle_contact(a, b)) << shown({x, y});
                ASSERT_EQ(triangle_contact(y, x), triangle_contact(a, b)) << shown({y, x});
            }
}

TEST_P(EveryFamily, ShowsAGapExactlyWhereTrianglesAreApart)
{
    check_gaps(pairs(300, 7));
    check_gaps(all_moved(pairs(300, 8), 1, 0));
    check_gaps(all_moved(pairs(60, 9), 1e-9, 1e3));
}

INSTANTIATE_TEST_SUITE_P(TriangleTest, EveryFamily, testing::ValuesIn(triangle_families()),
                         [](const auto& family) { return test_name(family.param); });

// On a grid of 3 x 3 x 3 points triangles share corners and edges, are coplanar, or are segments and points.
TEST(TriangleTest, IsExactOnATinyGrid)
{
    GridPoints random(6);
    std::vector<TwoTriangles> pairs;
    for (int i = 0; i < 20000; ++i) pairs.emplace_back(random.triangle(1), random.triangle(1));
    check_gaps(pairs);
    const std::array<int, 3> count = check(pairs);
    for (int n : count) EXPECT_GT(n, 500);
}

/// A point, segment or triangle through small integers.
TrianglePoints degenerate(int corners, GridPoints& random)
{
    const Eigen::Vector3d p = random.point(8), q = random.point(8);
    if (corners == 1) return {p, p, p};
    if (corners == 2) return {p, Eigen::Vector3d(p + random.number(-2, 3) * (q - p)), q};
    return {p, q, random.point(8)};
}

TEST(TriangleTest, TakesSegmentsAndPointsAsWhatTheyAre)
{
    GridPoints random(7);
    for (int of_a = 1; of_a <= 3; ++of_a)
        for (int of_b = 1; of_b <= 3; ++of_b) {
            std::vector<TwoTriangles> pairs;
            for (int i = 0; i < 600; ++i) {
                const TrianglePoints a = degenerate(of_a, random);
                TrianglePoints b = degenerate(of_b, random);
                const Eigen::Vector3d shift = a[random.number(0, 2)] - b[random.number(0, 2)];
                if (i % 2) // lets them touch, or perhaps cross
                    for (Eigen::Vector3d& p : b) p += shift;
                if (i % 3 == 2)
                    for (TrianglePoints* t : {&pairs.emplace_back(a, b).first, &pairs.back().second})
                        for (Eigen::Vector3d& p : *t) p.z() = 0;
                else
                    pairs.emplace_back(a, b);
            }
            const std::array<int, 3> count = check(pairs);
            EXPECT_GT(count[0], 50) << of_a << " " << of_b;
            EXPECT_GT(count[1], 50) << of_a << " " << of_b;
        }
}

TEST(TriangleTest, IsExactForSubnormalAndHugeCoordinates)
{
    GridPoints random(8);
    for (double scale : {0x1p-1074, 0x1p-1060, 0x1p-1000, 0x1p-400, 0x1p400, 0x1p1000, 0x1.8p1022}) {
        std::vector<TwoTriangles> pairs;
        for (int i = 0; i < 300; ++i) {
            pairs.emplace_back(random.triangle(1), random.triangle(1));
            for (TrianglePoints* t : {&pairs.back().first, &pairs.back().second})
                for (Eigen::Vector3d& p : *t) p *= scale;
        }
        check(pairs);
    }
}

TEST(TriangleTest, IsExactWhereMagnitudesAreFarApart)
{
    GridPoints random(9);
    const auto any = [&](int spread) { return std::ldexp(random.number(-3, 3), random.number(-spread, spread)); };
    for (int spread : {50, 300, 1000}) {
        std::vector<TwoTriangles> pairs;
        for (int i = 0; i < (spread == 1000 ? 4 : 300); ++i) {
            auto& [a, b] = pairs.emplace_back();
            for (TrianglePoints* t : {&a, &b})
                for (Eigen::Vector3d& p : *t) p = {any(spread), any(spread), any(spread)};
            if (i % 2) b[0] = a[0];
        }
        check(pairs);
    }
}

/// Distance of a point from a triangle that is not a sliver.
double distance(const TrianglePoints& t, const Eigen::Vector3d& p)
{
    const Eigen::Vector3d normal = (t[1] - t[0]).cross(t[2] - t[0]).normalized();
    double inside = 0, nearest = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < 3; ++k) {
        const Eigen::Vector3d &a = t[k], edge = t[(k + 1) % 3] - a;
        inside = std::max(inside, edge.normalized().cross(normal).dot(p - a));
        const double along = std::clamp(edge.dot(p - a) / edge.squaredNorm(), 0.0, 1.0);
        nearest = std::min(nearest, (a + along * edge - p).norm());
    }
    return inside > 0 ? nearest : std::abs(normal.dot(p - t[0]));
}

/// Length of the common segment of two triangles in different planes.
double length_of_contact(const TrianglePoints& a, const TrianglePoints& b)
{
    const Eigen::Vector3d m = (a[1] - a[0]).cross(a[2] - a[0]), n = (b[1] - b[0]).cross(b[2] - b[0]);
    const Eigen::Vector3d line = m.cross(n).normalized();
    double low = -std::numeric_limits<double>::infinity(), high = -low;
    const auto cut = [&](const TrianglePoints& t, const Eigen::Vector3d& normal, const Eigen::Vector3d& origin) {
        double first = std::numeric_limits<double>::infinity(), last = -first;
        for (std::size_t k = 0; k < 3; ++k) {
            const Eigen::Vector3d &p = t[k], &q = t[(k + 1) % 3];
            const double x = normal.dot(p - origin), y = normal.dot(q - origin);
            if ((x > 0) == (y > 0)) continue;
            const double at = line.dot(p + x / (x - y) * (q - p) - a[0]);
            first = std::min(first, at), last = std::max(last, at);
        }
        low = std::max(low, first), high = std::min(high, last);
    };
    cut(a, n, b[0]), cut(b, m, a[0]);
    return std::max(high - low, 0.0); // rounding can miss a short segment
}

TEST_P(EveryFamily, HasContactsInBothTriangles)
{
    int met = 0;
    std::vector<TwoTriangles> some = pairs(1000, 10);
    for (const TwoTriangles& pair : all_moved(some, 1e-6, 0)) some.push_back(pair);
    for (const auto& [a, b] : some) {
        const TriangleContact contact = triangle_contact(a, b);
        if (contact == TriangleContact::separate) continue;
        const auto [ends, kind] = common_segment(a, b);
        EXPECT_EQ(kind, contact) << shown({a, b});
        const Eigen::Vector3d normal_a = unit_normal(a[0], a[1], a[2]), normal_b = unit_normal(b[0], b[1], b[2]);
        double largest = 0, thinnest = 1;
        for (const TrianglePoints* t : {&a, &b}) {
            for (const Eigen::Vector3d& p : *t) largest = std::max(largest, p.cwiseAbs().maxCoeff());
            const Eigen::Vector3d u = (*t)[1] - (*t)[0], v = (*t)[2] - (*t)[0];
            thinnest = std::min(thinnest, u.cross(v).norm() / std::max(u.squaredNorm(), v.squaredNorm()));
        }
        if (thinnest < 1e-2) continue; // distance() is too inaccurate for these
        ++met;
        for (const Eigen::Vector3d& p : ends) {
            EXPECT_LE(distance(a, p), 0x1p-43 * largest) << shown({a, b});
            EXPECT_LE(distance(b, p), 0x1p-43 * largest) << shown({a, b});
        }
        EXPECT_NEAR(normal_a.norm(), 1, 1e-15);
        EXPECT_LE(normal_a.cross((a[1] - a[0]).cross(a[2] - a[0]).normalized()).norm(), 1e-11);
        if (contact == TriangleContact::crossing && normal_a.cross(normal_b).norm() > 1e-2) {
            EXPECT_NEAR((ends[1] - ends[0]).norm(), length_of_contact(a, b), 1e-9 * largest) << shown({a, b});
        }
    }
    if (GetParam().name != "slivers") {
        EXPECT_GT(met, 50);
    }
}

TEST(CommonSegment, IsThePointWhereACornerTouches)
{
    GridPoints random(13);
    for (int i = 0; i < 500; ++i) {
        const TrianglePoints a = of_sixteenths(random, 1 << 20);
        const Eigen::Vector3d at = inside(a, random), normal = (a[1] - a[0]).cross(a[2] - a[0]).normalized();
        const TrianglePoints b{at, at + normal * 100 + random.point(50), at + normal * 100 + random.point(50)};
        if (triangle_contact(a, b) != TriangleContact::touching) continue;
        const auto found = common_segment(a, b).ends;
        EXPECT_LE((found[0] - at).cwiseAbs().maxCoeff(), 0x1p-48 * 0x1p20);
        EXPECT_LE((found[1] - at).cwiseAbs().maxCoeff(), 0x1p-48 * 0x1p20);
    }
}

TEST(CommonSegment, IsTheLongestSegmentOfAnOverlapInOnePlane)
{
    const TrianglePoints a{Eigen::Vector3d(0, 0, 5), Eigen::Vector3d(4, 0, 5), Eigen::Vector3d(0, 4, 5)};
    const TrianglePoints b{Eigen::Vector3d(1, 1, 5), Eigen::Vector3d(5, 1, 5), Eigen::Vector3d(1, 5, 5)};
    const auto found = common_segment(a, b).ends;
    EXPECT_NEAR((found[0] - found[1]).norm(), std::sqrt(8), 1e-14); // from (3, 1) to (1, 3)
    EXPECT_EQ(unit_normal(a[0], a[1], a[2]), Eigen::Vector3d::UnitZ());
}

TEST(CommonSegment, IsFoundForSegmentsAndPoints)
{
    GridPoints random(14);
    int met = 0;
    for (int i = 0; i < 20000; ++i) {
        const TrianglePoints a = random.triangle(1), b = random.triangle(1);
        if (!triangles_meet(a, b)) continue;
        ++met;
        const auto found = common_segment(a, b).ends;
        for (const Eigen::Vector3d& p : found) {
            // Coordinates here are simple fractions: the point times their denominator is on the grid.
            int n = 1;
            while (((n * p).array().round() - (n * p).array()).abs().maxCoeff() > 1e-12 && n < 1000) ++n;
            ASSERT_LT(n, 1000) << shown({a, b}) << p.transpose();
            const Eigen::Vector3d on_grid = (n * p).array().round();
            for (TrianglePoints t : {a, b}) {
                for (Eigen::Vector3d& q : t) q *= n;
                EXPECT_TRUE(triangles_meet(t, {on_grid, on_grid, on_grid})) << shown({a, b}) << p.transpose();
            }
        }
    }
    EXPECT_GT(met, 1000);
}

} // namespace
} // namespace oncollide
