#include <gtest/gtest.h>

#include <cmath>

#include <oncollide/narrowphase/shapes/exact_cores.hpp>

namespace oncollide::exact_cores_test {
namespace {

double gap_of(const Shape& a, const Shape& b, const Eigen::Vector3d& at)
{
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() = at;
    return exact_gap(convex_of(a), convex_of(b), RelativePose(Eigen::Isometry3d::Identity(), pose));
}

TEST(ExactCores, TouchingBoxesHaveNoGapAndTheNeighbouringDoubleHasOne)
{
    const Box unit{{0.5, 0.5, 0.5}};
    const double next = std::nextafter(1.0, 2.0);
    for (int axis = 0; axis < 3; ++axis) {
        Eigen::Vector3d at = Eigen::Vector3d::Zero();
        at[axis] = 1;
        EXPECT_EQ(gap_of(unit, unit, at), 0) << axis;
        at[axis] = next;
        const double gap = gap_of(unit, unit, at);
        EXPECT_GT(gap, 0) << axis;
        EXPECT_LE(gap, next - 1) << axis;
    }
    EXPECT_EQ(gap_of(unit, unit, {1, 1, 1}), 0) << "corners";
    EXPECT_EQ(gap_of(unit, unit, {0.25, 0.5, 0.75}), 0) << "they overlap";
}

TEST(ExactCores, IsALowerBoundOfTheDistance)
{
    const Box unit{{0.5, 0.5, 0.5}};
    for (const double x : {1e-9, 1e-3, 1.0, 100.0}) {
        const double diagonal = std::sqrt(3.0) * x;
        const double gap = gap_of(unit, unit, Eigen::Vector3d::Constant(1 + x));
        EXPECT_GT(gap, 0) << x;
        EXPECT_LE(gap, diagonal * (1 + 1e-12)) << x;
    }
}

TEST(ExactCores, CountsTheRadiusOfACapsule)
{
    const Box unit{{0.5, 0.5, 0.5}};
    const Capsule rod{0.25, 1};
    EXPECT_EQ(gap_of(unit, rod, {0.75, 0, 0}), 0);
    const double next = std::nextafter(0.75, 1.0), gap = gap_of(unit, rod, {next, 0, 0});
    EXPECT_GT(gap, 0);
    EXPECT_LE(gap, next - 0.75);
}

} // namespace
} // namespace oncollide::exact_cores_test
