// Bodies over a half-space, z <= 0 in its frame, compared with closed forms.
#include <gtest/gtest.h>

#include <cmath>

#include <oncollide/narrowphase/pairs/half_space.hpp>

namespace oncollide::half_space_pair_test {
namespace {

constexpr double slack = 0x1p-49;

struct Placed {
    Model model;
    RelativePose to_plane;

    Placed(const Shape& shape, double height, double tilt = 0)
        : model(std::make_shared<const Geometry>(Geometry{"shape", shape, {}})),
          to_plane(Eigen::Isometry3d::Identity(), Eigen::Isometry3d(Eigen::Translation3d(0, 0, height) *
                                                                    Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitY())))
    {
    }
    HalfSpacePair<operand::Solid> pair() { return {model, to_plane, slack}; }
};

TEST(HalfSpacePair, OfABallAndATiltedBoxIsTheHeightOfTheLowestPoint)
{
    for (const double height : {3.0, 1.5, 1.0 + 1e-9}) {
        const ConvexDistance d = Placed(Sphere{1}, height).pair().distance(INFINITY);
        EXPECT_NEAR(d.lower, height - 1, 1e-12);
        EXPECT_NEAR(d.upper, height - 1, 1e-12);
        EXPECT_LE(d.lower, height - 1);
        EXPECT_EQ(Placed(Sphere{1}, height).pair().meeting().sign, 1);
    }
    const double tilt = 0.4, lowest = std::cos(tilt) * 0.5 + std::sin(tilt) * 1;
    const ConvexDistance d = Placed(Box{{1, 2, 0.5}}, 2, tilt).pair().distance(INFINITY);
    EXPECT_NEAR(d.upper, 2 - lowest, 1e-12);
    EXPECT_NEAR(d.on_a.z(), 0, 1e-12);
    EXPECT_NEAR((d.on_a - d.on_b).norm(), d.upper, 1e-12);
}

TEST(HalfSpacePair, DepthsAreCertifiedIntervals)
{
    for (const double height : {0.9, 0.5, 0.0, -7.0}) {
        const auto depth = Placed(Sphere{1}, height).pair().depth();
        EXPECT_LE(depth.lower, 1 - height);
        EXPECT_GE(depth.upper, 1 - height);
        EXPECT_NEAR(depth.upper, depth.lower, 1e-12);
        EXPECT_NEAR(depth.lowest.z(), height - 1, 1e-12);
        EXPECT_EQ(Placed(Sphere{1}, height).pair().meeting().sign, -1);
    }
    EXPECT_EQ(Placed(Sphere{1}, 2).pair().depth().lower, 0) << "outside";
}

TEST(HalfSpacePair, HigherThanTheCutoffThereAreNoPoints)
{
    const ConvexDistance d = Placed(Sphere{1}, 10).pair().distance(2);
    EXPECT_GT(d.lower, 2);
    EXPECT_LE(d.lower, 9);
}

} // namespace
} // namespace oncollide::half_space_pair_test
