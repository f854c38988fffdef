// Meshes that meet themselves, as models of a World and without one.
#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
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

TEST(NearFeaturesOfAMesh, AreThoseOfTwoBodiesInOnePlaceWithoutNeighbours)
{
    Mesh mesh = make_torus_knot_mesh(3, 7, 1, 0.4, 0.35, 3000);
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) // edges that are not parallel
        mesh.vertices[v] += 0.02 * Eigen::Vector3d(u01(1, v, 0), u01(1, v, 1), u01(1, v, 2));
    mesh = make_mesh("knot", mesh.vertices, mesh.triangles);
    constexpr double dhat = 0.03;
    World world({.threads = 2});
    const ModelId model = world.models().add(mesh);
    const auto found = world.models().near_features(model, dhat);
    const PlacedModel here{model, Eigen::Isometry3d::Identity()};
    std::map<std::pair<FeatureBits, FeatureBits>, double> of_copies;
    for (const NearFeatures& f : world.pairs().near_features(here, here, dhat))
        of_copies.emplace(std::minmax(f.a, f.b), f.upper);
    std::size_t same = 0;
    for (const NearFeatures& f : found) {
        const auto at = of_copies.find({f.a, f.b});
        ASSERT_NE(at, of_copies.end());
        EXPECT_NEAR(f.upper, at->second, 1e-12);
        ++same;
    }
    EXPECT_GT(same, 1000u);
    // The copies also list features that share a vertex.
    EXPECT_LT(found.size(), of_copies.size());
    EXPECT_EQ(near_features(mesh, dhat).size(), found.size());
}

TEST(NearFeaturesOfAMesh, RefuseOptionsOutOfRangeAndOtherKinds)
{
    World world;
    const Mesh box = make_box_mesh({1, 1, 1});
    const ModelId model = world.models().add(box);
    const auto fault = [&](double dhat, const SelfNearOptions& options) -> std::string {
        try {
            world.models().near_features(model, dhat, options);
        } catch (const Error& error) {
            EXPECT_EQ(error.kind(), ErrorKind::usage);
            return error.what();
        }
        return {};
    };
    std::vector<Eigen::Vector3d> rest = box.vertices;
    EXPECT_EQ(fault(0.1, {.rest = rest, .rest_distance = 1}), "");
    EXPECT_NE(fault(-1, {}).find("dhat"), std::string::npos);
    EXPECT_NE(fault(NAN, {}).find("dhat"), std::string::npos);
    EXPECT_NE(fault(1, {.rings = 0}).find("rings"), std::string::npos);
    EXPECT_NE(fault(1, {.rest_distance = 1}).find("rest"), std::string::npos);
    EXPECT_NE(fault(1, {.rest = std::span(rest).first(3)}).find("3 positions"), std::string::npos);
    EXPECT_NE(fault(1, {.rest = rest, .rest_distance = NAN}).find("rest_distance"), std::string::npos);
    rest[2].y() = NAN;
    EXPECT_NE(fault(1, {.rest = rest}).find("position 2"), std::string::npos);
    EXPECT_THROW(world.models().near_features(world.models().add(Box{{1, 1, 1}}), 0.1), Error);
}

} // namespace
} // namespace oncollide::self_contacts_test
