// A vector that a product replaces is read before it is written. Without cmake/toolchains/no_load_splat.py, Clang
// 14 breaks this in WebAssembly.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

namespace oncollide {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

[[gnu::noinline]] void turn(const Isometry3d& pose, Vector3d& point)
{
    point = pose * point;
}
[[gnu::noinline]] void turn_linear(const Isometry3d& pose, Vector3d& point)
{
    point = pose.linear() * point;
}
[[gnu::noinline]] void scale_by_last(Vector3d& point)
{
    const double factor = point.z();
    point.z() = 7;
    point.head<2>() *= factor;
}
/// Lanes of one number; the place of the number is written before they are used.
[[gnu::noinline]] void add_first(double* numbers, const double* others)
{
    const double first = numbers[0];
    for (int k = 0; k < 8; ++k) numbers[k] = first + others[k];
}

TEST(InPlace, AProductReadsAPointBeforeItReplacesIt)
{
    Isometry3d pose = Isometry3d::Identity();
    pose.linear() << 0, -1, 0, 1, 0, 0, 0, 0, 1;
    pose.translation() = Vector3d(1, 2, 3);
    pose.linear().col(2) = Vector3d(1, 1, 2); // each result depends on z
    Vector3d point(2, 3, 4);
    turn(pose, point);
    EXPECT_EQ(point, Vector3d(2, 8, 11));
    turn_linear(pose, point);
    EXPECT_EQ(point, Vector3d(3, 13, 22));
    scale_by_last(point);
    EXPECT_EQ(point, Vector3d(66, 286, 7));
}

TEST(InPlace, ALoopAddsTheNumberThatItReplaces)
{
    double numbers[8] = {10}, others[8];
    for (int k = 0; k < 8; ++k) others[k] = k + 1;
    add_first(numbers, others);
    for (int k = 0; k < 8; ++k) EXPECT_EQ(numbers[k], 11 + k);
}

} // namespace
} // namespace oncollide
