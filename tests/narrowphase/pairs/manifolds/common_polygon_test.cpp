#include <oncollide/narrowphase/pairs/manifolds/common_polygon.hpp>

#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>

namespace oncollide::common_polygon_test {
namespace {

using Eigen::Vector3d;

double area_of(const std::vector<Vector3d>& polygon)
{
    double area = 0;
    for (std::size_t i = 2; i < polygon.size(); ++i)
        area += 0.5 * (polygon[i - 1] - polygon[0]).cross(polygon[i] - polygon[0]).z();
    return area;
}

TEST(CommonPolygon, IsAHexagonOfTwoTrianglesThatPointApart)
{
    const double h = std::sqrt(3.0) / 2;
    const TrianglePoints a{Vector3d(1, 0, 0), Vector3d(-0.5, h, 0), Vector3d(-0.5, -h, 0)};
    TrianglePoints b{Vector3d(-a[0]), Vector3d(-a[1]), Vector3d(-a[2])};
    const std::vector<Vector3d> polygon = common_polygon(a, b, Vector3d::UnitZ());
    EXPECT_EQ(polygon.size(), 6u);
    EXPECT_NEAR(area_of(polygon), 0.75 * std::sqrt(3.0) * 2 / 3, 1e-12);
    std::swap(b[1], b[2]);
    EXPECT_NEAR(area_of(common_polygon(a, b, Vector3d::UnitZ())), area_of(polygon), 1e-12) << "seen from below";
}

TEST(CommonPolygon, HasTheSameAreaInBothOrdersAndLiesInBoth)
{
    int meet = 0;
    for (std::uint64_t seed = 0; seed < 500; ++seed) {
        const auto corner = [&](std::uint64_t k) { return Vector3d(u01(seed, k, 0), u01(seed, k, 1), 0); };
        const auto triangle = [&](std::uint64_t k) {
            TrianglePoints t{corner(k), corner(k + 1), corner(k + 2)};
            if ((t[1] - t[0]).cross(t[2] - t[0]).z() < 0) std::swap(t[0], t[1]);
            return t;
        };
        const TrianglePoints a = triangle(0), b = triangle(3);
        const std::vector<Vector3d> polygon = common_polygon(a, b, Vector3d::UnitZ());
        EXPECT_NEAR(area_of(polygon), area_of(common_polygon(b, a, Vector3d::UnitZ())), 1e-12) << seed;
        meet += area_of(polygon) > 1e-3;
        for (const TrianglePoints& t : {a, b})
            for (int k = 0; k < 3; ++k)
                for (const Vector3d& p : polygon)
                    EXPECT_GT((t[(k + 1) % 3] - t[k]).cross(p - t[k]).z(), -1e-12) << seed;
        for (std::uint64_t k = 0; k < 20; ++k) { // a point of both is in the polygon
            const Vector3d p = corner(10 + k);
            const auto holds = [&](const auto& t) {
                for (std::size_t i = 0; i < t.size(); ++i)
                    if ((t[(i + 1) % t.size()] - t[i]).cross(p - t[i]).z() < 1e-9) return false;
                return t.size() > 2;
            };
            EXPECT_TRUE(!(holds(a) && holds(b)) || holds(polygon)) << seed;
        }
    }
    EXPECT_GT(meet, 100);
}

TEST(CommonPolygon, TrianglesInOnePlaneAreFoundExactly)
{
    const TrianglePoints a{Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(0, 1, 0)};
    EXPECT_TRUE(in_one_plane(a, {Vector3d(5, 5, 0), Vector3d(6, 5, 0), Vector3d(5, 7, 0)}));
    EXPECT_FALSE(in_one_plane(a, {Vector3d(5, 5, 0), Vector3d(6, 5, 0), Vector3d(5, 7, 0x1p-1000)}));
}

} // namespace
} // namespace oncollide::common_polygon_test
