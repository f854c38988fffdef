// Cooked meshes that are opened where bodies come near.
#include "pipeline/models/cooked_scenes.hpp"
#include <chrono>
#include <thread>

namespace oncollide::cooked_scenes {
namespace {

/// Adjacent tiles, each of which is opened when a sphere approaches, and spheres that roll over them.
struct TiledWorld {
    std::vector<std::shared_ptr<const CookedMesh>> tiles;
    Scene scene;

    TiledWorld(const TemporaryFolder& folder, bool as_tiles, const Eigen::Vector3d& off = Eigen::Vector3d::Zero())
    {
        constexpr std::uint32_t across = 4, cells = 60;
        for (std::uint32_t i = 0; i < across * across; ++i) {
            const fs::path file = folder.path() / fmt::format("tile{}.cooked", i);
            const Mesh mesh = make_hills_mesh(across * cells, 0.5, 6, 1, i % across * cells, i / across * cells, cells);
            if (!fs::exists(file)) cook_mesh(mesh, file);
            CookedOutline outline = CookedMesh(file).outline();
            outline.bounds.min += off, outline.bounds.max += off;
            if (as_tiles) tiles.push_back(std::make_shared<const CookedMesh>(file, outline));
            const GeometryId tile = as_tiles ? scene.add(fmt::format("tile {}", i), tiles.back())
                                             : scene.add(fmt::format("tile {}", i), mesh);
            scene.add_body({.name = fmt::format("tile {}", i), .geometry = tile, .is_static = true});
        }
        const GeometryId ball = scene.add("ball", make_sphere_mesh(1, 200));
        for (std::uint64_t i = 0; i < 6; ++i)
            scene.add_body({.name = fmt::format("ball {}", i),
                            .geometry = ball,
                            .pose = Eigen::Isometry3d(Eigen::Translation3d(5, 5 + 1.5 * double(i), 3)),
                            .motion = Drift{.velocity = {1.5, 0.5, 0}, .spin = {0, 0.1, 0}, .walls = {}}});
    }
    std::ptrdiff_t open() const
    {
        return std::ranges::count_if(tiles, [](const auto& tile) { return tile->is_open(); });
    }
};

TEST(Cooked, TilesAreOpenedWhereBodiesComeAndGivenBack)
{
    const TemporaryFolder folder;
    const Settings settings{.exact = ExactLevel::predicates, .age_limit = 8};
    TiledWorld plain(folder, false), tiled(folder, true);
    EXPECT_EQ(tiled.open(), 0);
    Pipeline of_plain(plain.scene, settings), of_tiled(tiled.scene, settings);
    EXPECT_EQ(tiled.open(), 0);
    Mover mover_a, mover_b;
    std::ptrdiff_t most = 0;
    std::size_t met = 0;
    for (int frame = 0; frame < 70; ++frame) {
        mover_a.move(plain.scene, frame), mover_b.move(tiled.scene, frame);
        met += of_plain.step(plain.scene).pairs.size();
        of_tiled.step(tiled.scene);
        most = std::max(most, tiled.open());
    }
    EXPECT_EQ(of_plain.hash(), of_tiled.hash());
    EXPECT_GT(met, 100u);
    EXPECT_GT(most, 0);
    EXPECT_LE(most, 6);
    EXPECT_LT(tiled.open(), most + 1);
    EXPECT_TRUE(of_tiled.world().inspect().file_faults.empty());
}

TEST(Cooked, LookingAheadNeverChangesAResult)
{
    const TemporaryFolder folder;
    const Settings plain{.exact = ExactLevel::predicates};
    const Played expected = play(TiledWorld(folder, false).scene, plain, 40);
    for (const Settings& settings : {Settings{.exact = ExactLevel::predicates, .look_ahead = 10},
                                     Settings{.exact = ExactLevel::predicates, .age_limit = 2, .look_ahead = 5},
                                     Settings{.exact = ExactLevel::predicates,
                                     .threads = 3,
                                     .age_limit = 5,
                                     .resident_budget = 600'000,
                                     .look_ahead = 20}}) {
        const Played played = play(TiledWorld(folder, true).scene, settings, 40);
        expect_same(expected, played);
        EXPECT_TRUE(played.faults.empty());
    }
    EXPECT_THROW(World({.memory_budget = 1'000'000, .look_ahead = 1}), Error);
}

TEST(Cooked, LookingAheadOpensTilesBeforeBodiesMeetThem)
{
    const TemporaryFolder folder;
    TiledWorld world(folder, true);
    World bare({.exact = ExactLevel::predicates, .look_ahead = 60});
    std::vector<ModelId> models;
    for (std::size_t i = 0; i < world.tiles.size(); ++i)
        bare.bodies().add({.model = bare.models().add(world.tiles[i]), .is_static = true});
    const BodyId ball = bare.bodies().add({.model = bare.models().add(make_sphere_mesh(1, 200))});
    for (int frame = 0; frame < 90 && world.open() == 0; ++frame) { // towards them
        bare.bodies().set_pose(ball, Eigen::Isometry3d(Eigen::Translation3d(-30 + 0.3 * frame, 50, 3)));
        EXPECT_TRUE(bare.step().pairs.empty());
        std::this_thread::sleep_for(std::chrono::milliseconds(frame < 40 ? 0 : 5));
    }
    EXPECT_GT(world.open(), 0);
}

TEST(Cooked, NothingRestsOnBoundsThatATileContradicts)
{
    const TemporaryFolder folder;
    TiledWorld wrong(folder, true, {0, 0, 0.25});
    const Played played = play(wrong.scene, {.exact = ExactLevel::predicates}, 3);
    ASSERT_FALSE(played.frames[2].empty());
    std::size_t with_tiles = 0;
    for (const PairResult& pair : played.frames[2]) {
        if (pair.a.slot >= 16) continue; // two spheres
        ++with_tiles;
        EXPECT_EQ(pair.verdict, Verdict::undecided);
        EXPECT_GE(pair.bound, 1e15);
    }
    EXPECT_GT(with_tiles, 0u);
    ASSERT_FALSE(played.faults.empty());
    EXPECT_NE(played.faults[0].find("does not match the index"), std::string::npos) << played.faults[0];
    EXPECT_NE(played.faults[0].find("results undecided"), std::string::npos) << played.faults[0];
}

TEST(Cooked, ATileThatIsGoneCostsItsPairs)
{
    const TemporaryFolder folder;
    TiledWorld world(folder, true);
    fs::remove(folder.path() / "tile0.cooked");
    folder.write("tile1.cooked", "no tile");
    for (const Settings& settings : {Settings{.exact = ExactLevel::predicates}, Settings{},
                                     Settings{.exact = ExactLevel::predicates, .look_ahead = 10}}) {
        const Played played = play(world.scene, settings, 60);
        std::size_t undecided = 0, decided = 0;
        for (const auto& frame : played.frames)
            for (const PairResult& pair : frame) {
                if (pair.a.slot >= 16) continue;
                EXPECT_EQ(pair.verdict == Verdict::undecided, pair.a.slot < 2) << pair.a.slot;
                ++(pair.verdict == Verdict::undecided ? undecided : decided);
            }
        EXPECT_GT(undecided, 0u);
        EXPECT_GT(decided, 0u);
        EXPECT_EQ(played.faults.size(), 2u);
    }
}

} // namespace
} // namespace oncollide::cooked_scenes
