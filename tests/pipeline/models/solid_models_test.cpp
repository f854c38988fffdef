#include <algorithm>

#include <gtest/gtest.h>

#include <oncollide/base/error.hpp>
#include <oncollide/narrowphase/model.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>

#include "narrowphase/mesh_parts.hpp"

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
    const Mesh box = holed_box();
    World world({.mode = Mode::solid});
    const ModelId holed = world.models().add(box, "holed");
    try {
        world.bodies().add({.model = holed});
        FAIL() << "accepted";
    } catch (const Error& error) {
        const std::string text = error.what();
        EXPECT_EQ(error.kind(), ErrorKind::bad_data);
        EXPECT_TRUE(text.starts_with("holed: ")) << text;
        EXPECT_NE(text.find("3 open edges"), std::string::npos) << text;
        const Triangle gone = make_box_mesh({1, 1, 1}).triangles.back();
        for (std::size_t i = 0; i < 3; ++i) // its neighbours traverse its edges in the opposite direction
            EXPECT_NE(text.find(std::to_string(gone[(i + 1) % 3]) + "-" + std::to_string(gone[i])), std::string::npos)
                << text;
        EXPECT_NE(text.find("open-as-surface"), std::string::npos) << text;
    }
    EXPECT_EQ(world.bodies().size(), 0u);
    World taken({.mode = Mode::solid, .open_as_surface = true});
    taken.bodies().add({.model = taken.models().add(box)});
    EXPECT_EQ(taken.bodies().size(), 1u);
}

TEST(Solids, NameOnlyTheFirstOfManyOpenEdges)
{
    World world({.mode = Mode::solid});
    const ModelId ground = world.models().add(make_terrain_mesh(8, 1, 8, 1), "ground");
    try {
        world.bodies().add({.model = ground});
        FAIL() << "accepted";
    } catch (const Error& error) {
        const std::string text = error.what();
        EXPECT_NE(text.find("32 open edges"), std::string::npos) << text;
        EXPECT_EQ(std::count(text.begin(), text.end(), '-'), 5 + 2) << "five edges, and the option: " << text;
    }
}

TEST(Solids, AreOnlyRequiredOfWhatBodiesUse)
{
    World world({.mode = Mode::solid});
    world.models().add(holed_box());
    world.bodies().add({.model = world.models().add(make_sphere_mesh(1, 200))});
    world.bodies().add({.model = world.models().add(Shape(Box{{1, 1, 1}}))});
    EXPECT_EQ(world.bodies().size(), 2u);
    const Model shape(std::make_shared<const Geometry>(Geometry{"shape", Shape(Box{{1, 1, 1}}), {}}));
    EXPECT_FALSE(shape.closed()) << "its tree has an inside already";
    EXPECT_EQ(shape.parts().size(), 1u);
}

TEST(Solids, KnowTheExtremePointsOfEveryPart)
{
    const Mesh two = joined({make_box_mesh({1, 2, 3}), moved(make_sphere_mesh(1, 200), {10, 0, 0})});
    const Model model(std::make_shared<const Geometry>(Geometry{"two", two, {}}));
    const auto parts = model.parts();
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
