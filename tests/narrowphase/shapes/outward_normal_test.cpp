#include <gtest/gtest.h>

#include <random>

#include <oncollide/narrowphase/shapes/outward_normal.hpp>

namespace oncollide::outward_normal_test {
namespace {

using Eigen::Vector3d;

TEST(OutwardNormal, IsTheNormalOfTheNearestFaceEdgeOrCorner)
{
    const Convex box = convex_of(Box{{1, 2, 3}}), ball = convex_of(Sphere{2}), capsule = convex_of(Capsule{1, 2}),
                 cylinder = convex_of(Cylinder{1, 2});
    const auto normal = [](const Convex& solid, double x, double y, double z) {
        return outward_normal(solid, Vector3d(x, y, z));
    };
    EXPECT_TRUE(normal(box, 0.9, 0, 0).isApprox(Vector3d::UnitX()));
    EXPECT_TRUE(normal(box, 0, -1.95, 0).isApprox(-Vector3d::UnitY()));
    EXPECT_TRUE(normal(box, 0.2, 0.1, 3.5).isApprox(Vector3d::UnitZ()));
    EXPECT_TRUE(normal(ball, 0, 1, 0).isApprox(Vector3d::UnitY()));
    EXPECT_TRUE(normal(ball, 0, 0, 0).isZero(0)) << "in the middle, all directions are equal";
    EXPECT_TRUE(normal(capsule, 0.5, 0, 1).isApprox(Vector3d::UnitX()));
    EXPECT_TRUE(normal(capsule, 0, 0, 2.9).isApprox(Vector3d::UnitZ()));
    EXPECT_TRUE(normal(cylinder, 0.95, 0, 0).isApprox(Vector3d::UnitX()));
    EXPECT_TRUE(normal(cylinder, 0, 0.1, 1.99).isApprox(Vector3d::UnitZ()));
}

/// The plane through the nearest point of the surface, across the normal, has the solid on one side.
TEST(OutwardNormal, SupportsTheSolidFromOutside)
{
    std::mt19937_64 random(3);
    std::normal_distribution<double> normal;
    const auto draw = [&] { return Vector3d(normal(random), normal(random), normal(random)); };
    for (const Shape& shape : {Shape(Box{{1, 2, 3}}), Shape(Sphere{2}), Shape(Capsule{1, 2}), Shape(Cylinder{1, 2}),
                               Shape(Cone{1, 2}), Shape(Ellipsoid{{1, 2, 3}})}) {
        const Convex solid = convex_of(shape);
        for (int k = 0; k < 500; ++k) {
            const Vector3d d = draw().normalized();
            const Vector3d on_surface = solid.support(d) + solid.radius * d;
            const Vector3d n = outward_normal(solid, on_surface * (1 + 1e-9));
            ASSERT_NEAR(n.norm(), 1, 1e-12);
            EXPECT_GE(n.dot(on_surface), solid.most_along(n) - 1e-6) << d.transpose();
        }
    }
}

} // namespace
} // namespace oncollide::outward_normal_test
