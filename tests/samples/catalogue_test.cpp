#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include <gtest/gtest.h>

#include "load_with_samples.hpp"
#include "scenes/same_scene.hpp"
#include "scenes/test_files.hpp"
#include <oncollide/base/numbers/random.hpp>
#include <oncollide/base/rigid.hpp>
#include <oncollide/samples/catalogue.hpp>

namespace oncollide {
namespace {

using Eigen::Vector3d;
using test::expect_error;

const Mesh& mesh_of(const Scene& scene, const char* geometry)
{
    return std::get<Mesh>(scene.geometries[index(scene.find_geometry(geometry).value())].data);
}

/// Options that make every scene small.
CatalogueOptions small(const std::string& name)
{
    CatalogueOptions options;
    const std::set<std::string> fixed{"paper", "paper-5k", "hard"};
    if (!fixed.contains(name)) options.bodies = name == "city" ? 60 : 9;
    return options;
}

TEST(Catalogue, ListsEverySceneOnceWithASummaryOfOneLine)
{
    std::set<std::string> names;
    for (const CatalogueEntry& entry : catalogue()) {
        EXPECT_TRUE(names.insert(entry.name).second) << entry.name;
        EXPECT_FALSE(entry.summary.empty());
        EXPECT_LE(entry.name.size() + entry.summary.size(), 110u);
        EXPECT_EQ(entry.summary.find('\n'), std::string::npos);
    }
    for (const char* name : {"paper", "paper-5k", "many", "boxes", "city", "octomap", "hills", "hard"})
        EXPECT_TRUE(names.contains(name)) << name;
}

class EveryScene : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Catalogue, EveryScene, testing::ValuesIn([] {
                             std::vector<std::string> names;
                             for (const CatalogueEntry& entry : catalogue()) names.push_back(entry.name);
                             return names;
                         }()),
                         [](const auto& name) {
                             std::string text = name.param;
                             std::replace(text.begin(), text.end(), '-', '_');
                             return text;
                         });

TEST_P(EveryScene, ComesBackBitForBitFromItsFile)
{
    const test::TemporaryFolder folder;
    Scene made = make_scene(GetParam(), small(GetParam()));
    EXPECT_EQ(made.name, GetParam());
    save_scene(made, folder.path() / "scene.json");
    Scene read = test::load_with_samples(folder.path() / "scene.json");
    test::expect_same_scene(made, read);

    // A file written from the scene that was read is identical: repeated saving changes nothing.
    std::filesystem::create_directory(folder.path() / "again");
    save_scene(read, folder.path() / "scene2.json");
    const auto content = [&](const char* name) {
        std::ifstream in(folder.path() / name);
        return std::string(std::istreambuf_iterator<char>(in), {});
    };
    EXPECT_EQ(content("scene.json"), content("scene2.json"));
}

TEST_P(EveryScene, ComesBackBitForBitWithTheDataFolder)
{
    const test::TemporaryFolder folder;
    CatalogueOptions options = small(GetParam());
    options.data = test::data_folder();
    if (options.data.empty()) GTEST_SKIP() << "skipped: no data";
    Scene made;
    try {
        made = make_scene(GetParam(), options);
    } catch (const Error& error) {
        if (std::string(error.what()).find("without GDAL") == std::string::npos) throw;
        GTEST_SKIP() << error.what();
    }
    for (const std::string& warning : made.warnings)
        EXPECT_EQ(warning.find("no data folder"), std::string::npos) << warning;
    save_scene(made, folder.path() / "scene.json");
    Scene read = test::load_with_samples(folder.path() / "scene.json");
    test::expect_same_scene(made, read);
}

TEST_P(EveryScene, IsTheSameForTheSameSeed)
{
    Scene a = make_scene(GetParam(), small(GetParam())), b = make_scene(GetParam(), small(GetParam()));
    test::expect_same_scene(a, b);
}

TEST_P(EveryScene, TakesTheNumberOfFramesWithoutChangingTheMotion)
{
    CatalogueOptions options = small(GetParam());
    options.frames = 5;
    Scene few = make_scene(GetParam(), options), all = make_scene(GetParam(), small(GetParam()));
    EXPECT_EQ(few.frames, 5);
    EXPECT_GT(all.frames, 5);
    all.frames = 5;
    test::expect_same_scene(few, all);
}

TEST_P(EveryScene, KeepsEveryPoseRigidAndFinite)
{
    Scene scene = make_scene(GetParam(), small(GetParam()));
    Mover mover;
    for (const int frame : {0, scene.frames / 2, scene.frames - 1}) {
        mover.move(scene, frame);
        for (std::size_t i = 0; i < scene.size(); ++i)
            EXPECT_EQ(why_not_rigid(scene.poses[i]), "") << scene.names[i] << " at frame " << frame;
    }
}

TEST_P(EveryScene, RefusesAbsurdNumbers)
{
    const std::string name = GetParam();
    for (const int bodies : {-1, 0, 2'000'000'000})
        expect_error(
            ErrorKind::usage, [&] { make_scene(name, {.bodies = bodies, .frames = {}, .data = {}}); }, name);
    for (const int frames : {-1, 0, 2'000'000'000})
        expect_error(
            ErrorKind::usage, [&] { make_scene(name, {.bodies = {}, .frames = frames, .data = {}}); }, name, "frames");
}

TEST(Catalogue, NamesTheKnownScenesForAnUnknownOne)
{
    expect_error(
        ErrorKind::usage, [] { make_scene("papr"); }, "'papr'",
        "paper, paper-5k, many, boxes, city, octomap, hills, avalanche, flags, campus, st-helens, chunks, tiles, "
        "swarm, hard");
}

TEST(Catalogue, SeedsChangeRandomScenes)
{
    for (const char* name : {"many", "boxes", "city", "octomap", "hills"}) {
        CatalogueOptions options = small(name);
        const Scene a = make_scene(name, options);
        options.seed = 1;
        const Scene b = make_scene(name, options);
        EXPECT_NE(a.poses.back().matrix(), b.poses.back().matrix()) << name;
    }
}

TEST(Catalogue, MakesAsManyBodiesAsAskedFor)
{
    for (const char* name : {"many", "boxes", "city"})
        for (const int bodies : {1, 2, 3, 50}) {
            CatalogueOptions options;
            options.bodies = bodies;
            EXPECT_EQ(make_scene(name, options).size(), std::size_t(bodies)) << name;
        }
}

TEST(Catalogue, SaysWhereAGeneratedMeshStandsIn)
{
    const Scene scene = make_scene("paper");
    ASSERT_EQ(scene.warnings.size(), 4u);
    EXPECT_NE(scene.warnings[0].find("bunny"), std::string::npos) << scene.warnings[0];
}

TEST(PaperScene, FollowsThePapersFormulaInEveryFrame)
{
    Scene scene = make_scene("paper");
    ASSERT_EQ(scene.frames, 2400);
    const std::size_t bunny = index(scene.find("bunny").value());
    Mover mover;
    for (int f = 0; f < 2400; ++f) {
        mover.move(scene, f);
        const double t = f / 2399.0, pi = std::numbers::pi;
        const Vector3d position(-4 + 8 * t, 0.9 * std::cos(10 * pi * t), 0.45 * std::sin(10 * pi * t));
        const Eigen::Matrix3d rotation =
            Eigen::AngleAxisd(8 * pi * t, Vector3d(1, 1, 1).normalized()).toRotationMatrix();
        ASSERT_EQ(scene.poses[bunny].translation(), position) << f;
        ASSERT_TRUE(scene.poses[bunny].linear().isApprox(rotation, 1e-14)) << f;
    }
    EXPECT_EQ(scene.poses[index(scene.find("dragon").value())].translation(), Vector3d(-2.5, 0, 0));
    EXPECT_EQ(scene.poses[index(scene.find("cow").value())].translation(), Vector3d(0, 0, 0));
    EXPECT_EQ(scene.poses[index(scene.find("lamp").value())].translation(), Vector3d(2.5, 0, 0));
    EXPECT_EQ(std::count(scene.is_static.begin(), scene.is_static.end(), 1), 3);
}

TEST(PaperScene, HasThePapersTriangleCountsWithAndWithoutData)
{
    for (const std::filesystem::path& data : {std::filesystem::path(), test::data_folder()}) {
        CatalogueOptions options;
        options.data = data;
        const Scene small = make_scene("paper", options), large = make_scene("paper-5k", options);
        const auto triangles = [](const Scene& scene, const char* name) {
            return mesh_of(scene, name).triangles.size();
        };
        EXPECT_EQ(triangles(small, "bunny"), 1500u);
        EXPECT_EQ(triangles(small, "cow"), 1500u);
        EXPECT_EQ(triangles(small, "dragon"), 1496u);
        EXPECT_EQ(triangles(small, "lamp"), 600u);
        EXPECT_EQ(triangles(large, "bunny"), 5110u);
        EXPECT_EQ(triangles(large, "cow"), 5144u);
        EXPECT_EQ(triangles(large, "dragon"), 5082u);
        EXPECT_EQ(triangles(large, "lamp"), 600u);
        for (const Scene* scene : {&small, &large})
            for (const Geometry& geometry : scene->geometries) {
                EXPECT_NEAR(bounds_of(geometry).diagonal(), 2, 1e-12) << geometry.name;
                EXPECT_LT(bounds_of(geometry).centre().norm(), 1e-12) << geometry.name;
            }
    }
}

TEST(ManyScene, IsTheBenchmarksScene)
{
    CatalogueOptions options;
    options.bodies = 3000;
    const Scene scene = make_scene("many", options);
    const double side = std::cbrt(9000.0);
    Vector3d mean = Vector3d::Zero(), mean_axis = Vector3d::Zero();
    double fastest = 0, fastest_spin = 0;
    const char* kinds[] = {"bunny", "dragon", "cow"};
    for (std::size_t i = 0; i < scene.size(); ++i) {
        EXPECT_EQ(scene.geometries[index(scene.geometry[i])].name, kinds[i % 3]);
        const Drift& drift = std::get<Drift>(scene.motions[i]);
        EXPECT_EQ(drift.walls.max, Vector3d::Constant(side));
        EXPECT_EQ(drift.walls.min, Vector3d::Zero());
        fastest = std::max(fastest, drift.velocity.cwiseAbs().maxCoeff());
        fastest_spin = std::max(fastest_spin, drift.spin.norm());
        mean += scene.poses[i].translation() / 3000;
        mean_axis += scene.poses[i].linear().col(0) / 3000;
    }
    EXPECT_NEAR(fastest, 0.02, 1e-4);
    EXPECT_LE(fastest, 0.02);
    EXPECT_NEAR(fastest_spin, 0.05, 1e-3);
    EXPECT_LE(fastest_spin, 0.05 + 1e-12);
    EXPECT_LT((mean - Vector3d::Constant(side / 2)).norm(), 0.06 * side);
    EXPECT_LT(mean_axis.norm(), 0.06) << "rotations must be uniform";
    EXPECT_EQ(std::count(scene.is_static.begin(), scene.is_static.end(), 1), 0);
}

TEST(BoxesScene, GivesTheBenchmarksPairsAndHashAfterSixtyFrames)
{
    // Boxes on a grid of 2^-13, low sides even and high sides odd, so that nothing touches exactly.
    Scene scene = make_scene("boxes");
    ASSERT_EQ(scene.size(), 1000u);
    Mover mover;
    mover.move(scene, 60);
    const double q = 0x1p-13;
    std::vector<Aabb> boxes(scene.size());
    for (std::size_t i = 0; i < scene.size(); ++i) {
        const Vector3d half = std::get<Box>(std::get<Shape>(scene.geometries[index(scene.geometry[i])].data)).half;
        for (int axis = 0; axis < 3; ++axis) {
            const double low = 2 * std::floor((scene.poses[i].translation()[axis] - half[axis]) / (2 * q));
            boxes[i].min[axis] = low * q;
            boxes[i].max[axis] = (low + 2 * std::floor(half[axis] / q) + 1) * q;
        }
    }
    std::size_t pairs = 0;
    std::uint64_t hash = 0;
    for (std::uint64_t a = 0; a < boxes.size(); ++a)
        for (std::uint64_t b = a + 1; b < boxes.size(); ++b)
            if (boxes[a].overlaps(boxes[b])) ++pairs, hash += splitmix(a << 32 | b);
    EXPECT_EQ(pairs, 938u);
    EXPECT_EQ(hash, 0x2c42a71ad89f921fu);
}

TEST(CityScene, HasStaticSceneryAndMoversOnLayersThatMeet)
{
    const Scene scene = make_scene("city");
    EXPECT_EQ(scene.size(), 2021u);
    std::size_t movers = 0;
    for (std::size_t i = 0; i < scene.size(); ++i) {
        const bool moves = !std::holds_alternative<Still>(scene.motions[i]);
        movers += moves;
        EXPECT_EQ(scene.is_static[i], !moves);
        EXPECT_EQ(scene.layers[i] == 1, !moves);
        if (moves) {
            EXPECT_NE(scene.masks[i] & 1, 0u) << scene.names[i] << " must collide with the scenery";
        }
    }
    EXPECT_EQ(movers, 20u);
}

TEST(CityScene, SendsCarsAlongStreetsToTheLastFrame)
{
    Scene scene = make_scene("city");
    const std::size_t car = index(scene.find("car-0").value());
    const Keyed& route = std::get<Keyed>(scene.motions[car]);
    EXPECT_GE(route.keys.back().time, scene.frames);
    for (int frame = 0; frame < scene.frames; frame += 7) {
        const Eigen::Isometry3d pose = pose_at(route, scene.start_pose(car), frame);
        const auto off_street = [](double x) { return std::abs(std::remainder(x, 60.0)); };
        EXPECT_LT(std::min(off_street(pose.translation().x()), off_street(pose.translation().y())), 5.01) << frame;
    }
}

TEST(HardScene, HoldsTheCasesItPromises)
{
    const Scene scene = make_scene("hard");
    EXPECT_EQ(mesh_of(scene, "slivers").zero_area, 2u);
    EXPECT_EQ(mesh_of(scene, "triangle").triangles.size(), 1u);
    EXPECT_EQ(mesh_of(scene, "plate").triangles.size(), 2u);
    const auto pose = [&](const char* name) { return scene.poses[index(scene.find(name).value())]; };
    EXPECT_EQ(pose("twin-a").matrix(), pose("twin-b").matrix());
    EXPECT_EQ(pose("plate-b").translation().z() - pose("plate-a").translation().z(), 1e-12);
    EXPECT_EQ(pose("touch-mesh-face").translation() - pose("touch-mesh").translation(), Vector3d(1, 0, 0));
    EXPECT_GE(pose("far-cube-a").translation().minCoeff(), 1e6);
    EXPECT_EQ(pose("far-ring-b").translation() - pose("far-ring-a").translation(),
              pose("near-ring-b").translation() - pose("near-ring-a").translation());
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_EQ(scene.warnings[0], "slivers: 2 triangles without area (kept)");
}

TEST(LargeScenes, AreMadeAsTheirSummariesSay)
{
    const auto movers = [](const Scene& scene) { return scene.motions.bodies().size(); };
    const auto still = [](const Scene& scene) { return std::size_t(std::ranges::count(scene.is_static, 1)); };
    const Scene swarm = make_scene("swarm", {.bodies = 1000});
    EXPECT_EQ(swarm.size(), 1000u);
    EXPECT_EQ(movers(swarm), 10u);
    EXPECT_EQ(still(swarm), 990u);
    const Scene chunks = make_scene("chunks", {.bodies = 184});
    EXPECT_EQ(chunks.size(), 184u);
    EXPECT_EQ(still(chunks), 144u) << "a square of chunks";
    EXPECT_EQ(movers(chunks), 40u);
    EXPECT_EQ(mesh_of(chunks, "chunk 3 2").triangles.size(), 578u);
    const Scene tiles = make_scene("tiles", {.bodies = 24, .frames = 8});
    EXPECT_EQ(still(tiles), 16u) << "a square of tiles";
    EXPECT_EQ(movers(tiles), 8u);
    EXPECT_EQ(mesh_of(tiles, "ground/5").triangles.size(), 10'082u);
    for (const auto& [a, b] : {std::pair("ground/5", "ground/6"), std::pair("ground/5", "ground/9")}) {
        const auto& vertices = mesh_of(tiles, b).vertices; // the tiles join
        EXPECT_EQ(std::ranges::count_if(mesh_of(tiles, a).vertices,
                                        [&](const auto& v) { return std::ranges::count(vertices, v); }),
                  72);
    }
    const Scene mountain = make_scene("st-helens", {.bodies = 40});
    const auto& ground = std::get<Terrain>(mountain.geometries[0].data);
    for (const std::uint32_t body : mountain.motions.bodies()) {
        const Keyed* route = std::get_if<Keyed>(&mountain.motions[body]);
        if (!route) continue;
        ASSERT_GT(route->keys.size(), 5u);
        EXPECT_GT(route->keys.back().time, 599);
        const Vector3d at = mountain.poses[body].translation();
        const auto cell = [](double x) { return static_cast<std::uint32_t>(std::lround(x / 30)); };
        EXPECT_LT(at.z() - ground.height(cell(at.x()), cell(at.y())), 1.8) << "on the ground";
    }
}

TEST(Catalogue, LetsAnAvalancheGoDownItsHill)
{
    Scene scene = make_scene("avalanche", {.bodies = 84});
    const auto& hill = std::get<Terrain>(scene.geometries[0].data);
    EXPECT_EQ(scene.size(), 85u);
    const auto is_mesh = [&](std::size_t i) {
        return std::holds_alternative<Mesh>(scene.geometries[index(scene.geometry[i])].data);
    };
    std::set<std::size_t> shapes;
    std::size_t meshes = 0;
    for (std::size_t i = 1; i < scene.size(); ++i) {
        meshes += is_mesh(i);
        if (!is_mesh(i)) shapes.insert(std::get<Shape>(scene.geometries[index(scene.geometry[i])].data).index());
    }
    EXPECT_EQ(meshes, 4u) << "one in 21";
    EXPECT_EQ(shapes.size(), 7u) << "every kind except the half-space";
    const auto above = [&](std::size_t i) { // a corner of its cell
        const Vector3d p = scene.poses[i].translation();
        return p.z() -
               hill.height(std::uint32_t(p.x() / hill.spacing().x()), std::uint32_t(p.y() / hill.spacing().y()));
    };
    for (std::size_t i = 1; i < scene.size(); ++i) EXPECT_GT(above(i), 0.4) << i;
    Mover().move(scene, scene.frames - 1);
    for (std::size_t i = 1; i < scene.size(); ++i) {
        EXPECT_NEAR(above(i), 0.15, 0.15) << i;
        EXPECT_GT(scene.poses[i].translation().x(), scene.start_pose(i).translation().x() + 1) << i;
    }
}

} // namespace
} // namespace oncollide
