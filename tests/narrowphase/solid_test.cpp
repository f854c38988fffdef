#include <gtest/gtest.h>

#include <oncollide/narrowphase/solid.hpp>
#include <oncollide/scenes/mesh_generators.hpp>

namespace oncollide {
namespace {

TEST(WindingNumber, IsOneInsideAndZeroOutside)
{
    const Mesh torus = make_torus_mesh(2, 0.5, 2000);
    EXPECT_NEAR(std::abs(winding_number(torus, {2, 0, 0})), 1, 1e-9);
    EXPECT_NEAR(winding_number(torus, {0, 0, 0}), 0, 1e-9);
    EXPECT_NEAR(winding_number(torus, {9, 0, 0}), 0, 1e-9);
}

TEST(SolidTest, SeesOneBodyInsideAnother)
{
    Scene scene;
    const GeometryId big = scene.add("big", make_sphere_mesh(2, 500)),
                     small = scene.add("small", make_box_mesh({0.1, 0.1, 0.1})),
                     open = scene.add("open", make_terrain_mesh(8, 1, 8, 1));
    const auto put = [&](const char* name, GeometryId g, double x) {
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        pose.translation().x() = x;
        return index(scene.add_body({.name = name, .geometry = g, .pose = pose}));
    };
    const auto ball = put("ball", big, 0), inner = put("inner", small, 1), outer = put("outer", small, 3),
               ground = put("ground", open, 0);
    const SolidTest solid(scene);
    EXPECT_TRUE(solid.encloses(scene, ball, inner));
    EXPECT_TRUE(solid.encloses(scene, inner, ball));
    EXPECT_FALSE(solid.encloses(scene, ball, outer));
    EXPECT_FALSE(solid.encloses(scene, ground, inner)) << "an open mesh has no inside";
}

TEST(SolidTest, SeesOneOfSeveralParts)
{
    // One mesh of two far cubes: the second is inside the ball, the first is not.
    Mesh two = make_box_mesh({0.1, 0.1, 0.1});
    std::vector<Eigen::Vector3d> vertices = two.vertices;
    std::vector<Triangle> triangles = two.triangles;
    const auto n = static_cast<std::uint32_t>(vertices.size());
    for (const Eigen::Vector3d& v : two.vertices) vertices.push_back(v - Eigen::Vector3d(5, 0, 0));
    for (Triangle t : two.triangles) triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
    Scene scene;
    const GeometryId ball = scene.add("ball", make_sphere_mesh(2, 500)),
                     pair = scene.add("pair", make_mesh("pair", vertices, triangles));
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation().x() = 5;
    const auto a = index(scene.add_body({.name = "a", .geometry = ball})),
               b = index(scene.add_body({.name = "b", .geometry = pair, .pose = pose}));
    EXPECT_TRUE(SolidTest(scene).encloses(scene, a, b));
}

} // namespace
} // namespace oncollide
