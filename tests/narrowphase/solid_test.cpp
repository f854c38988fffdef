#include <algorithm>

#include <gtest/gtest.h>

#include <oncollide/base/error.hpp>
#include <oncollide/narrowphase/exact/solid.hpp>
#include <oncollide/scenes/catalogue/mesh_generators.hpp>

#include "mesh_parts.hpp"

namespace oncollide {
namespace {

Mesh holed_box()
{
    Mesh mesh = make_box_mesh({1, 1, 1});
    mesh.triangles.pop_back();
    return mesh;
}

TEST(Solids, RefuseAMeshThatIsNotClosedAndNameItsOpenEdges)
{
    Scene scene;
    const Mesh box = holed_box();
    scene.add_body({.name = "body", .geometry = scene.add("holed", box)});
    try {
        Solids(scene, false);
        FAIL() << "accepted";
    } catch (const Error& error) {
        const std::string text = error.what();
        EXPECT_EQ(error.kind(), ErrorKind::bad_data);
        EXPECT_TRUE(text.starts_with("holed: ")) << text;
        EXPECT_NE(text.find("3 open edges"), std::string::npos) << text;
        const Triangle gone = make_box_mesh({1, 1, 1}).triangles.back();
        for (std::size_t i = 0; i < 3; ++i) // its neighbours run along its edges the other way
            EXPECT_NE(text.find(std::to_string(gone[(i + 1) % 3]) + "-" + std::to_string(gone[i])), std::string::npos)
                << text;
        EXPECT_NE(text.find("open-as-surface"), std::string::npos) << text;
    }
    const Solids taken(scene, true);
    EXPECT_FALSE(taken.solid(scene.geometry[0]));
}

TEST(Solids, NameOnlyTheFirstOfManyOpenEdges)
{
    Scene scene;
    scene.add_body({.name = "body", .geometry = scene.add("ground", make_terrain_mesh(8, 1, 8, 1))});
    try {
        Solids(scene, false);
        FAIL() << "accepted";
    } catch (const Error& error) {
        const std::string text = error.what();
        EXPECT_NE(text.find("32 open edges"), std::string::npos) << text;
        EXPECT_EQ(std::count(text.begin(), text.end(), '-'), 5 + 2) << "five edges, and the option: " << text;
    }
}

TEST(Solids, AskOnlyWhatBodiesUse)
{
    Scene scene;
    scene.add("holed", holed_box());
    const GeometryId ball = scene.add("ball", make_sphere_mesh(1, 200)), shape = scene.add("shape", Box{{1, 1, 1}});
    scene.add_body({.name = "a", .geometry = ball});
    scene.add_body({.name = "b", .geometry = shape});
    const Solids solids(scene, false);
    EXPECT_TRUE(solids.solid(ball));
    EXPECT_FALSE(solids.solid(shape)) << "its tree has an inside already";
    EXPECT_EQ(solids.parts(shape).size(), 1u);
}

TEST(Solids, KnowTheExtremePointsOfEveryPart)
{
    Scene scene;
    const Mesh two = joined({make_box_mesh({1, 2, 3}), moved(make_sphere_mesh(1, 200), {10, 0, 0})});
    scene.add_body({.name = "two", .geometry = scene.add("two", two)});
    const Solids solids(scene, false);
    const auto parts = solids.parts(scene.geometry[0]);
    ASSERT_EQ(parts.size(), 2u);
    for (const auto& [part, mesh] : {std::pair(parts[0], make_box_mesh({1, 2, 3})),
                                     std::pair(parts[1], moved(make_sphere_mesh(1, 200), {10, 0, 0}))}) {
        Aabb bounds;
        for (const Eigen::Vector3d& point : part) bounds.add(point);
        EXPECT_EQ(bounds.min, mesh.bounds.min);
        EXPECT_EQ(bounds.max, mesh.bounds.max);
    }
}

} // namespace
} // namespace oncollide
