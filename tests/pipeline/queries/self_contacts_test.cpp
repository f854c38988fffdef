// Meshes that meet themselves, as models of a World and without one.
#include <gtest/gtest.h>

#include <oncollide/narrowphase/cook_mesh.hpp>
#include <oncollide/pipeline/two_geometries.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

#include "temporary_folder.hpp"

namespace oncollide::self_contacts_test {
namespace {

TEST(SelfContacts, AreTheSameWithAndWithoutAWorldAndForAnyNumberOfThreads)
{
    const Mesh soup = make_soup_mesh(9000, 0.1, 1.5, 4), knot = make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 2000);
    const auto pairs = self_contacts(soup);
    EXPECT_GT(pairs.size(), 1000u);
    EXPECT_TRUE(std::ranges::is_sorted(pairs));
    EXPECT_TRUE(self_contacts(knot).empty());
    for (const int threads : {1, 3}) {
        World world({.threads = threads});
        const ModelId of_soup = world.models().add(soup);
        EXPECT_EQ(world.models().self_contacts(of_soup), pairs);
        EXPECT_EQ(world.models().self_contacts(of_soup, 7), self_contacts(soup, 7));
        EXPECT_EQ(world.models().self_contacts(of_soup, 1).size(), 1u);
        EXPECT_TRUE(world.models().self_contacts(world.models().add(knot)).empty());
    }
}

TEST(SelfContacts, OfACookedMeshHaveTheNumbersOfTheMesh)
{
    test::TemporaryFolder folder;
    const Mesh soup = make_soup_mesh(2000, 0.2, 1.5, 5);
    cook_mesh(soup, folder / "soup.cooked");
    World world({.resident_budget = std::size_t{1} << 20});
    const ModelId model = world.models().add(load_geometry(folder / "soup.cooked"));
    EXPECT_EQ(world.models().self_contacts(model), self_contacts(soup));
}

TEST(SelfContacts, OfOtherKindsAreNone)
{
    World world;
    EXPECT_TRUE(world.models().self_contacts(world.models().add(Box{{1, 1, 1}})).empty());
    EXPECT_TRUE(world.models().self_contacts(world.models().add(make_hills(8, 8, 1, 3, 1))).empty());
    EXPECT_TRUE(world.models().self_contacts(world.models().add(make_building_map(2, 0.2, 1))).empty());
}

TEST(SelfContacts, RefuseIdsAndMeshesThatAreNotValid)
{
    World world;
    EXPECT_THROW(world.models().self_contacts(ModelId{}), Error);
    Mesh broken = make_box_mesh({1, 1, 1});
    broken.triangles[0][0] = 100;
    EXPECT_THROW(self_contacts(broken), Error);
}

} // namespace
} // namespace oncollide::self_contacts_test
