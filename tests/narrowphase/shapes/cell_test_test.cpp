// Cells against triangles and cells, compared with separating axes in integers.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <random>

#include <oncollide/narrowphase/shapes/cell_test.hpp>

namespace oncollide::cell_test_test {
namespace {

using Eigen::Vector3d;
using Whole = std::array<std::int64_t, 3>;

Whole cross(const Whole& a, const Whole& b)
{
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
std::int64_t dot(const Whole& a, const Whole& b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Whole minus(const Whole& a, const Whole& b)
{
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

/// Thirteen axes separate a box and a triangle, if any direction does: all products are exact.
bool meet_by_axes(const Whole& low, const Whole& high, const std::array<Whole, 3>& t)
{
    std::vector<Whole> axes{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, cross(minus(t[1], t[0]), minus(t[2], t[0]))};
    for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t i = 0; i < 3; ++i) axes.push_back(cross(axes[i], minus(t[(k + 1) % 3], t[k])));
    for (const Whole& axis : axes) {
        std::int64_t least = 0, most = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            least += axis[i] * (axis[i] < 0 ? high[i] : low[i]), most += axis[i] * (axis[i] < 0 ? low[i] : high[i]);
        }
        const std::int64_t a = dot(axis, t[0]), b = dot(axis, t[1]), c = dot(axis, t[2]);
        if (std::max({a, b, c}) < least || std::min({a, b, c}) > most) return false;
    }
    return true;
}

struct Drawn {
    Aabb cell;
    TrianglePoints triangle;
    bool meet;
};

/// Small whole coordinates, so that many triangles touch the cell in a corner, along an edge or in a face.
Drawn draw(std::mt19937_64& random)
{
    const auto number = [&] { return std::int64_t(random() % 9) - 4; };
    Whole low, high;
    std::array<Whole, 3> t;
    for (std::size_t i = 0; i < 3; ++i) low[i] = number(), high[i] = low[i] + 1 + std::int64_t(random() % 3);
    for (Whole& p : t) p = {number(), number(), number()};
    const auto point = [](const Whole& p) { return Vector3d(double(p[0]), double(p[1]), double(p[2])); };
    return {{point(low), point(high)}, {point(t[0]), point(t[1]), point(t[2])}, meet_by_axes(low, high, t)};
}

TEST(CellTest, DecidesEveryTriangleAsIntegersDo)
{
    std::mt19937_64 random(7);
    int meet = 0;
    for (int k = 0; k < 50'000; ++k) {
        const Drawn d = draw(random);
        ASSERT_EQ(cell_meets(d.cell, d.triangle), d.meet) << k;
        meet += d.meet;
    }
    EXPECT_GT(meet, 5'000);
    EXPECT_LT(meet, 45'000);
}

TEST(CellTest, BoundsTheDistanceOfTrianglesThatDoNotMeet)
{
    std::mt19937_64 random(8);
    constexpr double rounding = 1e-14;
    for (int k = 0; k < 20'000; ++k) {
        const Drawn d = draw(random);
        const double most = cell_distance_at_most(d.cell, d.triangle);
        if (d.meet) {
            EXPECT_GE(most, 0);
            continue;
        }
        const NearestPoints nearest = cell_nearest(d.cell, d.triangle, rounding);
        const double gap = cell_gap(d.cell, d.triangle, rounding);
        EXPECT_GT(gap, 0) << k;
        EXPECT_LE(gap, nearest.distance + rounding) << k;
        EXPECT_LE(nearest.distance, most + rounding) << k;
        EXPECT_NEAR((nearest.a - nearest.b).norm(), nearest.distance, 1e-12) << k;
        EXPECT_LE((nearest.a - nearest.a.cwiseMax(d.cell.min).cwiseMin(d.cell.max)).norm(), 1e-12) << "in the cell";
        // No corner of the triangle is nearer to the cell.
        for (const Vector3d& corner : d.triangle)
            EXPECT_LE(nearest.distance, (corner - corner.cwiseMax(d.cell.min).cwiseMin(d.cell.max)).norm() + 1e-12)
                << k;
    }
}

TEST(CellTest, CellsInOneFrameMeetWhereTheirIntervalsDo)
{
    std::mt19937_64 random(9);
    const auto cell = [&] {
        Aabb box;
        for (int i = 0; i < 3; ++i)
            box.min[i] = double(random() % 7), box.max[i] = box.min[i] + 1 + double(random() % 2);
        return box;
    };
    for (int k = 0; k < 4'000; ++k) {
        const Aabb a = cell(), b = cell();
        const Vector3d apart = (b.min - a.max).cwiseMax(a.min - b.max).cwiseMax(0);
        ASSERT_EQ(cells_meet(a, corners_of(b)), apart.isZero(0)) << k;
        if (apart.isZero(0)) continue;
        EXPECT_NEAR(cells_nearest(a, corners_of(b), 1e-14).distance, apart.norm(), 1e-12) << k;
    }
}

} // namespace
} // namespace oncollide::cell_test_test
