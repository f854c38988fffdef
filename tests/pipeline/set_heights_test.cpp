// World::models().set_heights(): the call, its effects and its errors.
#include <gtest/gtest.h>

#include <oncollide/narrowphase/cook_mesh.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

#include "allocations.hpp"
#include "digging.hpp"
#include "refusal.hpp"
#include "temporary_folder.hpp"

namespace oncollide::set_heights_test {
namespace {

using Eigen::Isometry3d;

/// Flat ground of 40 x 30 heights, from -20 to 19 m and -15 to 14 m, and a ball above its column 22, row 16.
struct Ground {
    World world;
    ModelId ground;
    BodyId a, b;

    explicit Ground(const Settings& settings = {}, bool holes = false) : world(settings)
    {
        TerrainGrid grid{.columns = 40, .rows = 30};
        grid.origin = {-20, -15, 0};
        if (holes) grid.no_data = -9999;
        ground = world.models().add(make_terrain("ground", grid, std::vector<double>(1200)));
        a = world.bodies().add({.model = ground, .is_static = true});
        b = world.bodies().add(
            {.model = world.models().add(Shape(Sphere{0.5})), .pose = Isometry3d(Eigen::Translation3d(2, 1, 3))});
    }
    void raise(std::uint32_t column, std::uint32_t row, double height)
    {
        world.models().set_heights(ground, {column, row, 2, 1}, std::vector<double>{height, height});
    }
    Verdict verdict()
    {
        const FrameView view = world.step();
        return view.pairs.empty() ? Verdict::separate : view.pairs[0].verdict;
    }
};

TEST(SetHeights, IsSeenByBodiesAtRestAndAsleep)
{
    Ground s;
    EXPECT_EQ(s.verdict(), Verdict::separate);
    s.world.bodies().sleep(s.a), s.world.bodies().sleep(s.b);
    EXPECT_EQ(s.verdict(), Verdict::separate);
    s.raise(22, 16, 2.75);
    EXPECT_EQ(s.world.pairs().decide(s.a, s.b).verdict, Verdict::colliding) << "before the step, too";
    EXPECT_EQ(s.verdict(), Verdict::colliding);
    EXPECT_EQ(s.verdict(), Verdict::colliding);
    EXPECT_FALSE(s.world.manifolds().regions.empty());
    s.raise(22, 16, 2.25);
    EXPECT_EQ(s.verdict(), Verdict::separate);
    EXPECT_TRUE(s.world.manifolds().regions.empty());
    s.raise(0, 0, 2.75); // elsewhere
    EXPECT_EQ(s.verdict(), Verdict::separate);
    EXPECT_NEAR(s.world.pairs().distance(s.a, s.b).upper, 0.25, 1e-9);
}

TEST(SetHeights, KeepsAGapThatIsLargerThanTheChange)
{
    Ground s;
    s.raise(0, 0, 5); // their boxes overlap
    EXPECT_EQ(s.verdict(), Verdict::separate);
    s.raise(22, 16, 0.125);
    FrameView view = s.world.step();
    ASSERT_EQ(view.pairs.size(), 1u);
    EXPECT_EQ(view.trees.by_gap, 1u);
    EXPECT_LE(view.pairs[0].bound, s.world.pairs().distance(s.a, s.b).upper);
    s.raise(22, 16, 0.125);
    EXPECT_EQ(s.world.step().trees.kept, 1u) << "no height changed";
    s.raise(22, 16, 3);
    EXPECT_EQ(s.verdict(), Verdict::colliding);
}

/// A gap does not bound the distance of a cell that was not there.
TEST(SetHeights, DropsGapsWhenACellAppears)
{
    Ground s({}, true);
    std::vector<double> heights(9, -9999);
    s.world.models().set_heights(s.ground, {21, 15, 3, 3}, heights);
    s.raise(0, 0, 5);
    EXPECT_EQ(s.verdict(), Verdict::separate);
    heights.assign(9, 2.75);
    s.world.models().set_heights(s.ground, {21, 15, 3, 3}, heights);
    EXPECT_EQ(s.verdict(), Verdict::colliding);
    heights.assign(9, std::numeric_limits<double>::quiet_NaN());
    s.world.models().set_heights(s.ground, {21, 15, 3, 3}, heights);
    EXPECT_EQ(s.verdict(), Verdict::separate);
}

TEST(SetHeights, AllocatesNothingOnceWarm)
{
    Ground s({}, true);
    s.world.bodies().add({.model = s.ground, .pose = Isometry3d(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()))});
    DugTerrain dug(40, 30, 1, 0, 0.02, 5);
    std::vector<Dig> digs;
    for (int k = 0; k < 40; ++k) digs.push_back(dug.dig());
    const auto play = [&] {
        for (const Dig& dig : digs) {
            s.world.models().set_heights(s.ground, dig.where, dig.heights);
            s.world.step();
        }
    };
    play(), play();
    const std::size_t before = allocations;
    play();
    EXPECT_EQ(allocations, before);
}

TEST(SetHeights, LeavesTheGeometriesOfOthers)
{
    const auto shared = std::make_shared<const Geometry>(
        Geometry{"shared", make_terrain("shared", {.columns = 4, .rows = 4}, std::vector<double>(16)), {}});
    const auto height = [](const Geometry& g) { return std::get<Terrain>(g.data).height(1, 2); };
    World one, other;
    const ModelId a = one.models().add(shared), b = one.models().add(shared), c = other.models().add(shared);
    const std::vector<double> up{2}, more{3};
    one.models().set_heights(a, {1, 2, 1, 1}, up);
    const Geometry copy = one.models().geometry(a);
    one.models().set_heights(a, {1, 2, 1, 1}, more);
    EXPECT_EQ(height(*shared), 0);
    EXPECT_EQ(height(one.models().geometry(a)), 3);
    EXPECT_EQ(height(one.models().geometry(b)), 0);
    EXPECT_EQ(height(other.models().geometry(c)), 0);
    EXPECT_EQ(height(copy), 2);
    one.models().replace(a, copy.data);
    EXPECT_EQ(height(one.models().geometry(a)), 2);
    one.models().set_heights(a, {1, 2, 1, 1}, up);
    one.models().set_heights(a, {1, 2, 1, 1}, more);
    EXPECT_EQ(height(copy), 2);
    EXPECT_EQ(height(one.models().geometry(a)), 3);
}

TEST(SetHeights, RefusesWhatIsNoTerrainOrNotPartOfIt)
{
    Ground s;
    auto& models = s.world.models();
    const std::vector<double> six(6, 1);
    says(refusal([&] { models.set_heights(models.add(Shape(Sphere{1})), {0, 0, 3, 2}, six); }), "is not a terrain");
    says(refusal([&] { models.set_heights(ModelId{}, {0, 0, 3, 2}, six); }), "null");
    says(refusal([&] {
             models.set_heights(s.ground, {0, 0, 3, 3}, six);
         }),
         "6 heights are given for 3 columns and 3 rows");
    says(refusal([&] {
             models.set_heights(s.ground, {38, 0, 3, 2}, six);
         }),
         "3 columns and 2 rows of heights from column 38, row 0 are given, but the terrain has 40 columns and 30 rows");
    for (const TerrainRectangle beyond : {TerrainRectangle{0, 29, 3, 2}, TerrainRectangle{~0u, 0, 3, 2},
                                          TerrainRectangle{0, ~0u, 3, 2}, TerrainRectangle{41, 0, 0, 0}})
        says(refusal([&] { models.set_heights(s.ground, beyond, std::span(six).first(beyond.columns * beyond.rows)); }),
             "but the terrain has 40 columns");
    EXPECT_NO_THROW(models.set_heights(s.ground, {40, 30, 0, 0}, {}));
    const std::uint64_t hash = s.world.step().hash;
    for (const int before : {0, 1}) { // the first call copies the terrain
        if (before) models.set_heights(s.ground, {0, 0, 3, 2}, six);
        std::vector<double> bad = six;
        bad[4] = std::nan("");
        says(refusal([&] {
                 models.set_heights(s.ground, {7, 8, 3, 2}, bad);
             }),
             "terrain: the height in column 8, row 9 is nan; set no_data");
        bad[4] = 2e15;
        says(refusal([&] { models.set_heights(s.ground, {7, 8, 3, 2}, bad); }), "column 8, row 9 is 2000000000000000");
        EXPECT_EQ(std::get<Terrain>(models.geometry(s.ground).data).height(7, 8), 0) << "nothing has changed";
        EXPECT_EQ(s.world.step().hash, hash);
    }
}

TEST(SetHeights, RefusesATerrainInAFileAndSaysTheCure)
{
    const test::TemporaryFolder folder;
    const auto path = folder.path() / "hills.cooked";
    cook_terrain(make_hills(80, 80, 1, 5, 1), path);
    World world;
    const ModelId model = world.models().add(load_terrain(path));
    const std::vector<double> one{1};
    const std::string message = refusal([&] { world.models().set_heights(model, {0, 0, 1, 1}, one); });
    EXPECT_NE(message.find("is a terrain in a cooked file"), std::string::npos) << message;
    EXPECT_NE(message.find("make_terrain() makes one in memory"), std::string::npos) << message;
}

} // namespace
} // namespace oncollide::set_heights_test
