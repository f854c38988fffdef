#include <gtest/gtest.h>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>

#include "truth/integers.hpp"
#include "verify/cases/triangle_families.hpp"

namespace oncollide {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// The sign of the determinant in integers of 64 N bits; coordinates are multiples of 2^lowest.
template <int N>
int true_orientation(const std::array<Vector3d, 4>& at, int lowest)
{
    std::array<oracle::Point<N>, 3> edge;
    for (std::size_t i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
            edge[i][static_cast<std::size_t>(k)] = oracle::integer<oracle::Int<N>>(at[i + 1][k], lowest) -
                                                   oracle::integer<oracle::Int<N>>(at[0][k], lowest);
    const auto& [u, v, w] = edge;
    return (u[0] * v[1] * w[2] + u[1] * v[2] * w[0] + u[2] * v[0] * w[1] - u[2] * v[1] * w[0] - u[1] * v[0] * w[2] -
            u[0] * v[2] * w[1])
        .sign();
}

int orientation_of(const std::array<Vector3d, 4>& at)
{
    return orient3d(at[0], at[1], at[2], at[3]);
}

int filter_of(const std::array<Vector3d, 4>& at)
{
    return orient3d_filter(at[0], at[1], at[2], at[3]);
}

/// Fails if orient3d is wrong. Returns how often its filter did not determine a sign other than 0.
template <int N>
int check(const std::vector<std::array<Vector3d, 4>>& points, int lowest)
{
    int failed = 0;
    for (const auto& at : points) {
        const int truth = true_orientation<N>(at, lowest);
        EXPECT_EQ(orientation_of(at), truth);
        EXPECT_EQ(orient3d_exact(at[0], at[1], at[2], at[3]), truth);
        EXPECT_EQ(orient3d(at[1], at[0], at[2], at[3]), -truth);
        EXPECT_EQ(orient3d(at[1], at[2], at[3], at[0]), -truth);
        failed += truth && !filter_of(at);
    }
    return failed;
}

/// Three corners, and points within a few ulps of their plane.
std::vector<std::array<Vector3d, 4>> near_planes(int count, double size)
{
    GridPoints random(1);
    std::vector<std::array<Vector3d, 4>> all;
    for (int i = 0; i < count; ++i) {
        const TrianglePoints t = random.triangle(1 << 20);
        const Eigen::Matrix3d turn = random.rotation() * size * 0x1p-20;
        const Vector3d on_plane =
            t[0] + (t[1] - t[0]) * random.number(-99, 99) / 64.0 + (t[2] - t[0]) * random.number(-99, 99) / 64.0;
        Vector3d near = turn * on_plane;
        for (double& x : near) x += random.number(-2, 2) * 0x1p-52 * std::abs(x);
        all.push_back({turn * t[0], turn * t[1], turn * t[2], near});
    }
    return all;
}

TEST(Orient3d, IsExactNearPlanes)
{
    for (int exponent : {-60, -3, 0, 40}) {
        const int undecided = check<16>(near_planes(3000, std::ldexp(1, exponent)), exponent - 160);
        EXPECT_GT(undecided, 1000) << "these points must be too near for the filter";
    }
}

TEST(Orient3d, IsExactOnRandomPointsAndTheFilterDecidesThem)
{
    GridPoints random(2);
    std::vector<std::array<Vector3d, 4>> all;
    for (int i = 0; i < 20000; ++i) {
        all.emplace_back();
        const Eigen::Matrix3d turn = random.rotation();
        for (Vector3d& p : all.back()) p = turn * random.point(1 << 20);
    }
    EXPECT_LT(check<8>(all, -90), 3);
}

TEST(Orient3d, IsExactForSubnormalAndHugeCoordinates)
{
    GridPoints random(3);
    for (double scale : {0x1p-1074, 0x1p-1050, 0x1p-700, 0x1p-340, 0x1p340, 0x1p900, 0x1p1022}) {
        std::vector<std::array<Vector3d, 4>> all;
        for (int i = 0; i < 500; ++i) {
            all.emplace_back();
            for (Vector3d& p : all.back()) p = scale * random.point(i % 2 ? 1 : 3) / (scale > 1 ? 4 : 1);
        }
        check<8>(all, std::max(std::ilogb(scale) - 2, -1074));
    }
}

TEST(Orient3d, IsExactWhereMagnitudesAreFarApart)
{
    GridPoints random(4);
    for (int i = 0; i < 60; ++i) {
        std::array<Vector3d, 4> at;
        for (Vector3d& p : at)
            for (double& x : p) x = std::ldexp(random.number(-9, 9), random.number(-1074, 1020));
        check<200>({at}, -1074);
    }
}

TEST(Orient3d, IsExactWhereOnlySomeProductsUnderflowOrOverflow)
{
    GridPoints random(6);
    for (const auto& [one, two] : {std::pair(900, -540), std::pair(290, -540), std::pair(-340, 600)})
        for (int axis = 0; axis < 3; ++axis) {
            Vector3d scale = Vector3d::Constant(std::ldexp(1, two));
            scale[axis] = std::ldexp(1, one);
            for (int i = 0; i < 500; ++i) {
                std::array<Vector3d, 4> at;
                for (Vector3d& p : at) p = random.point(5);
                const int truth = true_orientation<2>(at, 0);
                for (Vector3d& p : at) p = p.cwiseProduct(scale);
                EXPECT_EQ(orientation_of(at), truth);
            }
        }
}

TEST(Orient3d, SeesSharedPointsAndPlanesSquareToAnAxis)
{
    const Vector3d a(0.1, 0.7, 3), b(0.3, 1e-9, 3), c(1e9, 0.2, 3), d(7, 8, 3), e(0, 0, 4);
    EXPECT_EQ(orient3d(a, b, c, d), 0);
    EXPECT_EQ(orient3d(a, b, e, a), 0);
    EXPECT_NE(orient3d(a, b, c, e), 0);
    EXPECT_EQ(orient3d({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}), 1) << "the side to which the normal points";
}

// Points around the middle of a long segment, one ulp apart: rounded arithmetic gives irregular signs here (Kettner et
// al., "Classroom examples of robustness problems in geometric computations", 2008).
TEST(Orient2d, IsExactOnThePointsOfAFineGrid)
{
    int undecided = 0;
    for (int i = 0; i < 64; ++i)
        for (int j = 0; j < 64; ++j) {
            const Vector2d p(0.5 + i * 0x1p-53, 0.5 + j * 0x1p-53), q(12, 12), r(24, 24);
            const double x = p.x(), y = p.y(); // q and r are on the diagonal
            EXPECT_EQ(orient2d(p, q, r), (x < y) - (x > y));
            EXPECT_EQ(orient2d(q, r, p), (x < y) - (x > y));
            EXPECT_EQ(orient2d(r, q, p), (x > y) - (x < y));
            undecided += orient2d_filter(p, q, r) == 0;
        }
    EXPECT_GT(undecided, 64);
}

TEST(Orient2d, IsExactNearLinesAndForExtremeCoordinates)
{
    GridPoints random(5);
    for (double scale : {0x1p-1074, 0x1p-530, 1.0, 0x1p500, 0x1p1020})
        for (int i = 0; i < 2000; ++i) {
            const Vector3d p = random.point(3), u = random.point(3);
            const int k = random.number(-2, 2), off = random.number(-1, 1);
            const Vector2d a = scale * p.head<2>() / (scale > 1 ? 4 : 1),
                           b = a + scale * u.head<2>() / (scale > 1 ? 4 : 1),
                           c = a + scale * (k * u.head<2>() + Vector2d(0, off)) / (scale > 1 ? 4 : 1);
            const int truth = off * static_cast<int>(u.x() > 0 ? 1 : u.x() < 0 ? -1 : 0);
            EXPECT_EQ(orient2d(a, b, c), truth);
            EXPECT_EQ(orient2d_exact(a, b, c), truth);
        }
}

TEST(Collinear, IsExact)
{
    const Vector3d a(0.1, 0.2, 0.3), b(0.4, 0.8, 1.6);
    EXPECT_TRUE(collinear(a, Vector3d(2 * b - a + (a - b)), b) == (Vector3d(2 * b - a + (a - b)) == b));
    EXPECT_TRUE(collinear({1, 2, 3}, {2, 4, 6}, {-3, -6, -9}));
    EXPECT_TRUE(collinear(a, a, b));
    EXPECT_FALSE(collinear({1, 2, 3}, {2, 4, 6}, {-3, -6, std::nextafter(-9.0, 0.0)}));
}

TEST(CrossingParameter, IsAccurateWhereBothEndsAreNearThePlane)
{
    // The plane z = x 2^-40: the exact fraction is a third for any size of the distances.
    const Vector3d a(0, 0, 0), b(1, 0, 0x1p-40), c(0, 1, 0);
    for (double far : {1.0, 0x1p-60, 0x1p-90})
        EXPECT_NEAR(crossing_parameter(a, b, c, {1, 5, 0x1p-40 + far}, {1, -7, 0x1p-40 - 2 * far}), 1 / 3.0, 0x1p-49)
            << far;
    EXPECT_EQ(crossing_parameter(a, b, c, {3, 3, 3 * 0x1p-40}, {1, 1, 1}), 0);
    EXPECT_EQ(crossing_parameter(a, b, c, {1, 1, 1}, {3, 3, 3 * 0x1p-40}), 1);
    EXPECT_NEAR(crossing_parameter(Vector2d(0, 0), Vector2d(3, 3), Vector2d(1, 0), Vector2d(0, 3)), 0.25, 0x1p-49);
}

TEST(UnitNormal, IsAccurateForNeedles)
{
    const Vector3d a(1e6, 1e6, 1e6), b = a + Vector3d(1024, 1024, 1024), c = a + Vector3d(512, 512, 512 + 0x1p-30);
    const Vector3d expected = Vector3d(1, -1, 0).normalized();
    EXPECT_LE((unit_normal(a, b, c) - expected).cwiseAbs().maxCoeff(), 0x1p-49);
    EXPECT_EQ(unit_normal(a, b, a), Vector3d::Zero());
}

TEST(ExactPredicates, RoundAlikeFromExtendedPrecisionAndFromIntegers)
{
    GridPoints random(31);
    int crossings = 0, flat = 0;
    for (int turn = 0; turn < 4000; ++turn) {
        // From ordinary triangles to slivers 2^-40 wide, also far away and at many scales.
        const Eigen::Matrix3d map = std::ldexp(1.0, random.number(-60, 60)) * random.rotation();
        const Vector3d far = turn % 3 ? Vector3d::Zero().eval() : Vector3d(map * random.point(1 << 30));
        TrianglePoints t = random.triangle(1 << 20);
        if (turn % 2) t[2] = t[0] + (t[1] - t[0]) * 0.375 + std::ldexp(1.0, -random.number(0, 40)) * random.point(99);
        for (Vector3d& p : t) p = map * p + far;
        const Vector3d p = map * random.point(1 << 20) + far, q = map * random.point(1 << 20) + far;
        const Vector3d normal = unit_normal_exact(t[0], t[1], t[2]);
        EXPECT_LE((unit_normal(t[0], t[1], t[2]) - normal).cwiseAbs().maxCoeff(), 0x1p-48);
        flat += normal.isZero();
        if (orient3d(t[0], t[1], t[2], p) * orient3d(t[0], t[1], t[2], q) >= 0) continue;
        ++crossings;
        const double exact = crossing_parameter_exact(t[0], t[1], t[2], p, q);
        EXPECT_NEAR(crossing_parameter(t[0], t[1], t[2], p, q), exact, 0x1p-48 * exact);
    }
    EXPECT_GT(crossings, 500);
    EXPECT_LT(flat, 100);
}

} // namespace
} // namespace oncollide
