#include <gtest/gtest.h>

#include "random_pose.hpp"

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/broadphase/aabb_kernel.hpp>
#include <oncollide/broadphase/bounds/support_map.hpp>

namespace oncollide {
namespace {

std::vector<Eigen::Vector3d> points_on_an_ellipsoid(std::uint32_t count, std::uint64_t seed)
{
    std::vector<Eigen::Vector3d> points;
    for (std::uint32_t i = 0; i < count; ++i) {
        const Eigen::Vector3d p(u01(seed, i, 0) - 0.5, u01(seed, i, 1) - 0.5, u01(seed, i, 2) - 0.5);
        points.push_back(p.normalized().cwiseProduct(Eigen::Vector3d(3, 1, 0.2)));
    }
    return points;
}

Eigen::Matrix3f rotation(std::uint64_t seed)
{
    return oncollide::random_pose(seed, 0).linear().cast<float>();
}

/// The projections of all points onto the rows, in double.
void expect_box_of(const std::vector<Eigen::Vector3d>& points, const Eigen::Matrix3f& rows, const Eigen::Vector3f& lo,
                   const Eigen::Vector3f& hi)
{
    Eigen::Vector3d low = rows.cast<double>() * points[0], high = low;
    for (const Eigen::Vector3d& point : points) {
        const Eigen::Vector3d along = rows.cast<double>() * point;
        low = low.cwiseMin(along), high = high.cwiseMax(along);
    }
    EXPECT_LT((lo.cast<double>() - low).cwiseAbs().maxCoeff(), 3e-6);
    EXPECT_LT((hi.cast<double>() - high).cwiseAbs().maxCoeff(), 3e-6);
}

TEST(SupportMap, GivesTheExtentOfAllPointsHoweverFarItIsRefined)
{
    for (const std::uint32_t count : {1u, 7u, 40u, 5000u}) {
        const auto points = points_on_an_ellipsoid(count, count);
        const SupportMap fresh(point_columns(points, Eigen::Vector3d::Zero()));
        SupportMap prepared(point_columns(points, Eigen::Vector3d::Zero())), complete = prepared;
        complete.complete();
        for (std::uint64_t seed = 0; seed < 300; ++seed) {
            const Eigen::Matrix3f rows = rotation(seed);
            for (int k = 0; k < 20; ++k) prepared.prepare(rows); // refined here, whole elsewhere
            Eigen::Vector3f lo, hi, other_lo, other_hi;
            fresh.box(rows, lo, hi);
            expect_box_of(points, rows, lo, hi);
            for (const SupportMap* map : {&prepared, &complete}) {
                map->box(rows, other_lo, other_hi);
                EXPECT_EQ(other_lo, lo) << count << " points, rotation " << seed;
                EXPECT_EQ(other_hi, hi) << count << " points, rotation " << seed;
            }
        }
    }
}

TEST(SupportMap, KeepsThePointsThatTieAlongTheAxes)
{
    std::vector<Eigen::Vector3d> corners;
    for (int k = 0; k < 8; ++k)
        for (int copy = 0; copy < 40; ++copy) corners.emplace_back(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1);
    SupportMap map(point_columns(corners, Eigen::Vector3d::Zero()));
    map.complete();
    Eigen::Vector3f lo, hi;
    map.box(Eigen::Matrix3f::Identity(), lo, hi);
    EXPECT_EQ(hi, Eigen::Vector3f::Ones());
    EXPECT_EQ(lo, -Eigen::Vector3f::Ones());
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
        const Eigen::Matrix3f rows = rotation(seed);
        map.box(rows, lo, hi);
        EXPECT_LT((hi - rows.cwiseAbs().rowwise().sum()).cwiseAbs().maxCoeff(), 1e-6f);
    }
}

TEST(SupportMap, RefinesOnlyWhereDirectionsRepeat)
{
    SupportMap map(point_columns(points_on_an_ellipsoid(5000, 3), Eigen::Vector3d::Zero()));
    const std::size_t whole = map.bytes();
    for (int k = 0; k < 200; ++k) map.prepare(rotation(1));
    const std::size_t refined = map.bytes();
    EXPECT_GT(refined, whole);
    for (int k = 0; k < 200; ++k) map.prepare(rotation(1));
    EXPECT_EQ(map.bytes(), refined) << "nothing is left to divide there";
    for (int k = 0; k < 200; ++k) map.prepare(rotation(2));
    EXPECT_GT(map.bytes(), refined);
}

TEST(UsedPoints, AreTheVerticesThatTrianglesUseRelativeToTheCentre)
{
    Mesh mesh;
    mesh.vertices = {{9, 9, 9}, {1, 0, 0}, {2, 0, 0}, {9, 9, 9}, {1, 5, 0}};
    mesh.triangles = {{1, 2, 4}, {4, 2, 1}};
    const PointColumns points = used_points(mesh, {1, 0, 0});
    ASSERT_EQ(points.size(), 8u) << "padded to the width of the kernels";
    const float expected[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 5, 0}};
    for (std::size_t i = 0; i < 8; ++i)
        for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_EQ(points.xyz[axis][i], expected[i < 3 ? i : 0][axis]) << i;
}

TEST(AabbKernel, TakesTheFirstPointOfTheFirstLaneWhereProjectionsAreEqual)
{
    const std::vector<float> zeros(24, 0.f);
    const float along_x[3] = {1, 0, 0};
    const auto farthest = [&](std::initializer_list<std::size_t> largest) {
        std::vector<float> x(24, -1.f);
        for (const std::size_t i : largest) x[i] = 7;
        const std::uint32_t found = baseline::aabb_kernel().farthest(x.data(), zeros.data(), zeros.data(), 24, along_x);
        EXPECT_EQ(aabb_kernel().farthest(x.data(), zeros.data(), zeros.data(), 24, along_x), found);
        return found;
    };
    EXPECT_EQ(farthest({13}), 13u);
    EXPECT_EQ(farthest({5, 13, 21}), 5u) << "one lane";
    EXPECT_EQ(farthest({3, 9, 17}), 9u) << "lanes 3, 1 and 1";
    EXPECT_EQ(farthest({0, 1, 2}), 0u);
}

} // namespace
} // namespace oncollide
