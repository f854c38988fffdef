#include <oncollide/narrowphase/pairs/manifolds/points/point_choice.hpp>

#include <algorithm>

#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>

namespace oncollide::point_choice_test {
namespace {

using Eigen::Vector3d;

std::vector<ManifoldCandidate> candidates_at(const std::vector<Vector3d>& points)
{
    std::vector<ManifoldCandidate> all;
    for (std::size_t i = 0; i < points.size(); ++i) all.push_back({points[i], ManifoldCandidate::of_a, i + 1, 0});
    return all;
}

/// The features of the kept candidates, in order.
std::vector<FeatureBits> kept_of(const std::vector<ManifoldCandidate>& all, std::size_t most)
{
    PointChoice choice;
    std::vector<FeatureBits> features;
    for (const std::uint32_t i : choice.choose(all, Vector3d::UnitZ(), most)) features.push_back(all[i].a);
    return features;
}

std::vector<Vector3d> random_points(std::uint64_t seed, std::size_t count)
{
    std::vector<Vector3d> points;
    for (std::size_t i = 0; i < count; ++i) points.emplace_back(u01(seed, i, 0), u01(seed, i, 1), 0);
    return points;
}

double area_of_triangle(const Vector3d& a, const Vector3d& b, const Vector3d& c)
{
    return 0.5 * std::abs((b - a).cross(c - a).z());
}

/// The area of the hull of up to four points in a plane: of the polygon, or of the triangle around the fourth.
double area_of(const std::vector<Vector3d>& p)
{
    if (p.size() < 3) return 0;
    if (p.size() == 3) return area_of_triangle(p[0], p[1], p[2]);
    const double triangles[] = {area_of_triangle(p[0], p[1], p[2]), area_of_triangle(p[0], p[1], p[3]),
                                area_of_triangle(p[0], p[2], p[3]), area_of_triangle(p[1], p[2], p[3])};
    return std::max(std::ranges::max(triangles), 0.5 * (triangles[0] + triangles[1] + triangles[2] + triangles[3]));
}

TEST(PointChoice, KeepsTheCornersOfAGrid)
{
    std::vector<Vector3d> grid;
    for (int x = 0; x < 7; ++x)
        for (int y = 0; y < 5; ++y) grid.emplace_back(x, y, 0);
    std::vector<FeatureBits> kept = kept_of(candidates_at(grid), 4);
    std::ranges::sort(kept);
    EXPECT_EQ(kept, (std::vector<FeatureBits>{1, 5, 31, 35}));
}

TEST(PointChoice, KeepsTheDeepestFirst)
{
    for (std::uint64_t seed = 0; seed < 50; ++seed) {
        std::vector<ManifoldCandidate> all = candidates_at(random_points(seed, 20));
        for (std::size_t i = 0; i < all.size(); ++i) all[i].depth = 0.1 * u01(seed, i, 2);
        const auto deepest = std::ranges::max_element(all, {}, &ManifoldCandidate::depth);
        for (const std::size_t most : {1u, 2u, 4u, 8u}) {
            const auto kept = kept_of(all, most);
            ASSERT_EQ(kept.size(), most == 8 ? kept.size() : most);
            EXPECT_EQ(kept.front(), deepest->a) << seed;
        }
    }
}

TEST(PointChoice, KeepsNoPointTwiceAndNoneThatAddsNoArea)
{
    const std::vector<Vector3d> line{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}};
    EXPECT_EQ(kept_of(candidates_at(line), 4), (std::vector<FeatureBits>{1, 4}));
    const std::vector<Vector3d> same(5, Vector3d(1, 2, 3));
    EXPECT_EQ(kept_of(candidates_at(same), 4).size(), 1u);
    std::vector<Vector3d> triangle{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {1, 1, 0}, {2, 2, 0}, {2, 0, 0}};
    std::vector<FeatureBits> kept = kept_of(candidates_at(triangle), 6);
    std::ranges::sort(kept);
    EXPECT_EQ(kept, (std::vector<FeatureBits>{1, 2, 3}));
}

TEST(PointChoice, DoesNotDependOnTheOrderOfTheCandidates)
{
    for (std::uint64_t seed = 0; seed < 50; ++seed) {
        std::vector<Vector3d> points; // many ties: of a coarse grid
        for (std::uint64_t i = 0; i < 24; ++i)
            points.emplace_back(std::floor(4 * u01(seed, i, 0)), std::floor(4 * u01(seed, i, 1)), 0);
        std::vector<ManifoldCandidate> all = candidates_at(points);
        for (std::size_t i = 0; i < all.size(); ++i) all[i].depth = 0.25 * std::floor(3 * u01(seed, i, 2));
        const auto kept = kept_of(all, 4);
        for (std::uint64_t turn = 0; turn < 5; ++turn) {
            for (std::size_t i = all.size() - 1; i > 0; --i)
                std::swap(all[i], all[std::size_t(double(i + 1) * u01(seed, i, 3 + turn))]);
            EXPECT_EQ(kept_of(all, 4), kept) << seed;
        }
    }
}

TEST(PointChoice, KeepsMostOfTheArea)
{
    double worst = 1;
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
        const std::vector<Vector3d> points = random_points(seed, 12);
        double best = 0;
        for (std::size_t i = 0; i < 12; ++i)
            for (std::size_t j = 0; j < i; ++j)
                for (std::size_t k = 0; k < j; ++k)
                    for (std::size_t l = 0; l < k; ++l)
                        best = std::max(best, area_of({points[i], points[j], points[k], points[l]}));
        std::vector<Vector3d> kept;
        for (const FeatureBits f : kept_of(candidates_at(points), 4)) kept.push_back(points[f - 1]);
        ASSERT_EQ(kept.size(), 4u);
        worst = std::min(worst, area_of(kept) / best);
    }
    EXPECT_GT(worst, 0.75);
    EXPECT_LE(worst, 1 + 1e-12);
}

TEST(PointChoice, LooksAlongTheNormal)
{
    // Along x, the points at z = 0 and z = 9 are apart; along z they are one.
    const auto all = candidates_at({{0, 0, 0}, {0, 0, 9}, {0, 1, 0}});
    PointChoice choice;
    EXPECT_EQ(choice.choose(all, Vector3d::UnitX(), 2).size(), 2u);
    const auto& kept = choice.choose(all, Vector3d::UnitZ(), 4);
    ASSERT_EQ(kept.size(), 2u);
    EXPECT_NE(all[kept[0]].at.y(), all[kept[1]].at.y());
}

} // namespace
} // namespace oncollide::point_choice_test
