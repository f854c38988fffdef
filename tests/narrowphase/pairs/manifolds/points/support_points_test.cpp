#include <oncollide/narrowphase/pairs/manifolds/points/support_points.hpp>

#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/model.hpp>

namespace oncollide::support_points_test {
namespace {

using Eigen::Vector3d;

std::vector<Vector3d> of(const Shape& shape, const Vector3d& direction)
{
    const Model model(std::make_shared<const Geometry>(Geometry{{}, shape, {}}));
    return support_points(model.convex(), direction.normalized());
}

TEST(SupportPoints, BeginWithTheFarthestPointOfTheShape)
{
    const Shape shapes[] = {Sphere{0.5}, Capsule{0.25, 0.5}, Cylinder{0.5, 0.25}, Cone{0.5, 0.5},
                            Ellipsoid{{0.5, 0.25, 0.75}}};
    for (const Shape& shape : shapes)
        for (std::uint64_t seed = 0; seed < 50; ++seed) {
            const Vector3d d =
                Vector3d(u01(seed, 0, 0) - 0.5, u01(seed, 0, 1) - 0.5, u01(seed, 0, 2) - 0.5).normalized();
            const Model model(std::make_shared<const Geometry>(Geometry{{}, shape, {}}));
            const std::vector<Vector3d> points = support_points(model.convex(), d);
            const double most = model.convex().most_along(d);
            const auto along = [&](const Vector3d& p) { return d.dot(p); };
            const bool is_cone = std::holds_alternative<Cone>(shape); // its apex is last
            EXPECT_NEAR(std::max(along(points.front()), is_cone ? along(points.back()) : -1), most, 1e-12)
                << shape.index();
            for (const Vector3d& p : points)
                for (std::uint64_t k = 0; k < 20; ++k) {
                    const Vector3d n =
                        Vector3d(u01(seed, 1 + k, 0) - 0.5, u01(seed, 1 + k, 1) - 0.5, u01(seed, 1 + k, 2) - 0.5)
                            .normalized();
                    EXPECT_LE(n.dot(p), model.convex().most_along(n) + 1e-12) << shape.index() << " is left";
                }
        }
}

TEST(SupportPoints, AreTheEndsOfALineAndTheCornersOfADisc)
{
    const auto capsule = of(Capsule{0.25, 0.5}, {1, 0, 0});
    ASSERT_EQ(capsule.size(), 2u);
    EXPECT_EQ(std::abs(capsule[0].z()), 0.25);
    EXPECT_EQ(capsule[1].z(), -capsule[0].z());
    EXPECT_EQ(capsule[0].x(), 0.25);
    const auto disc = of(Cylinder{0.5, 0.25}, {0, 0, 1});
    ASSERT_EQ(disc.size(), 5u);
    for (int k = 0; k < 4; ++k) {
        EXPECT_EQ(disc[k].z(), 0.125);
        EXPECT_NEAR(disc[k].head<2>().norm(), 0.5, 1e-15);
        EXPECT_NEAR((disc[k] + disc[(k + 2) % 4]).head<2>().norm(), 0, 1e-15);
    }
    EXPECT_EQ(disc[4].z(), -0.125);
    EXPECT_EQ(of(Sphere{0.5}, {0, 1, 0}).size(), 1u);
    const auto cone = of(Cone{0.5, 0.75}, {0, 0, 1});
    EXPECT_EQ(cone.size(), 5u);
    EXPECT_EQ(cone.back(), Vector3d(0, 0, 0.375)) << "the tip";
}

} // namespace
} // namespace oncollide::support_points_test
