// The results of many ranks must equal the results of one World, bit by bit.
#include <cmath>
#include <filesystem>
#include <fstream>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/samples/generators.hpp>

#include "ranks_fixture.hpp"

namespace oncollide {
namespace ranks_test {
namespace {

/// Cubes whose faces touch, on a lattice; every seventh is duplicated.
Scene lattice(int side)
{
    Scene scene;
    scene.name = "lattice", scene.frames = 2;
    const GeometryId box = scene.add("box", Box{Vector3d::Constant(0.5)}),
                     mesh = scene.add("mesh", make_box_mesh(Vector3d::Constant(0.5)));
    for (int i = 0; i < side * side * side; ++i) {
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        pose.translation() = Vector3d(i % side, i / side % side, i / side / side);
        for (int copies = i % 7 == 0 ? 2 : 1; copies > 0; --copies)
            scene.add_body({.geometry = i % 2 ? box : mesh, .pose = pose});
    }
    return scene;
}

Motion of_every_second(int i)
{
    return i % 2 ? Motion(Drift{.velocity = {0.3, 0.1, 0}, .walls = {}}) : Motion(Still{});
}

Scene balls(int count, double apart, const std::function<Motion(int)>& motion_of = of_every_second)
{
    Scene scene;
    scene.name = "balls", scene.frames = 3;
    const GeometryId ball = scene.add("ball", Sphere{1});
    for (int i = 0; i < count; ++i) {
        BodyInit body{.geometry = ball};
        body.pose.translation().x() = apart * i;
        body.motion = motion_of(i);
        scene.add_body(body);
    }
    return scene;
}

TEST_F(RanksTest, ScenesOfTheCatalogueAreThoseOfOneWorld)
{
    expect_the_same(catalogue_scene("city", 150, 4));
    expect_the_same(catalogue_scene("many", 60, 3));
    expect_the_same(catalogue_scene("octomap", 12, 3));
    expect_the_same(catalogue_scene("hills", 30, 3));
    expect_the_same(catalogue_scene("boxes", 400, 4)); // a random walk (brown)
    Scene campus = catalogue_scene("campus", 30, 2);
    EXPECT_EQ(by_many(campus, 4), by_one(campus));
}

TEST_F(RanksTest, MeshesThatDeformAreThoseOfOneWorld)
{
    Scene flags = catalogue_scene("flags", 60, 12);
    expect_the_same(flags);
    expect_the_same(flags, {.ignore_touching = true});
    expect_the_same(flags, {.threads = 2, .coherence = false});
    flags.pace = 7;
    expect_the_same(flags, {.exact = ExactLevel::predicates, .skip = {StageId::bounds}});
    for (const Settings& inexact : {Settings{.max_error = 0.01}, Settings{.depth = 5}, Settings{.clearance = 0.1},
                                    Settings{.exact = ExactLevel::off}})
        expect_refused(ErrorKind::usage, "geometry 'flag 0' deforms, and results within an error",
                       [&] { by_many(flags, 2, inexact); });
    expect_refused(ErrorKind::usage, "geometry 'flag 0' deforms: contacts on the way",
                   [&] { by_many(flags, 2, {}, {.continuous = true}); });
}

TEST_F(RanksTest, ARunOfMeshesThatDeformContinuesFromItsCheckpoint)
{
    const Scene flags = catalogue_scene("flags", 60, 30);
    RankedOptions options{.checkpoint = folder_ / "cp", .checkpoint_every = 10};
    by_many(flags, 3, {}, options, &make_morton_partitioner, 25);
    options.resume = true;
    EXPECT_EQ(by_many(flags, 2, {}, options), by_one(flags));
}

TEST_F(RanksTest, HardCasesAreThoseOfOneWorldInEverySetting)
{
    const Scene hard = catalogue_scene("hard", {}, 3);
    expect_the_same(hard);
    expect_the_same(hard, {.exact = ExactLevel::predicates});
    expect_the_same(hard, {.depth = 5});
    expect_the_same(hard, {.clearance = 0.01, .exact = ExactLevel::predicates});
    expect_the_same(hard, {.skip = {StageId::bounds, StageId::delimitation}});
}

TEST_F(RanksTest, RandomScenesAreThoseOfOneWorld)
{
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        SCOPED_TRACE(seed);
        const Scene scene = make_scene("random", {.bodies = 30, .frames = 4, .seed = seed, .data = {}});
        const Settings settings{.clearance = seed % 3 == 0 ? 0.05 : 0,
                                .exact = seed % 2 ? ExactLevel::predicates : ExactLevel::off};
        const Played one = by_one(scene, settings);
        for (const int size : {2, 5}) EXPECT_EQ(by_many(scene, size, settings), one) << size;
    }
}

TEST_F(RanksTest, FacesThatTouchOnACutAreDecidedOnce)
{
    expect_the_same(lattice(7));
    expect_the_same(lattice(5), {.clearance = 1});
}

TEST_F(RanksTest, EmptyRanksAndNoBodiesAreNoSpecialCases)
{
    for (const int count : {0, 1, 3}) expect_the_same(balls(count, 1.5));
    expect_the_same(balls(20, 0)); // all at one position
}

TEST_F(RanksTest, GiantsThatReachIntoEveryRegionAreDecidedOnce)
{
    Scene scene = balls(40, 1.5);
    const GeometryId giant = scene.add("giant", make_sphere_mesh(30, 500)), ground = scene.add("ground", HalfSpace{});
    for (int k = 0; k < 3; ++k)
        scene.add_body({.geometry = giant,
                        .pose = scene.poses[std::size_t(10 * k)],
                        .motion = Drift{.velocity = {0.1, 0, 0}, .walls = {}}});
    scene.add_body({.geometry = ground, .is_static = true});
    expect_the_same(scene);
}

TEST_F(RanksTest, FiltersAndExcludedPairsHoldAcrossRanks)
{
    Scene scene = balls(60, 0.4);
    for (std::uint32_t i = 0; i < scene.size(); ++i) {
        scene.set_layers(SceneBodyId{i}, 1u << i % 3, i % 5 ? 7 : 3),
            scene.set_group(SceneBodyId{i}, i % 4 == 0 ? 1 + i / 8 : 0);
        if (i % 3 == 0 && i + 2 < scene.size())
            scene.exclude(SceneBodyId{i}, SceneBodyId{i + 1}), scene.exclude(SceneBodyId{i + 2}, SceneBodyId{i});
    }
    expect_the_same(scene);
}

TEST_F(RanksTest, BodiesThatLeaveOneRegionForAnotherTakeTheirMotionAlong)
{
    Scene scene = balls(50, 2, [](int i) {
        const Aabb walls{Vector3d(0, -3, -3), Vector3d(100, 3, 3)};
        return i % 2 ? Motion(Jitter{.step = 9, .seed = 3, .index = std::uint32_t(i), .walls = walls})
                     : Motion(Drift{.velocity = {3.0, 0, 0}, .walls = walls});
    });
    scene.frames = 40;
    const Played one = by_one(scene);
    EXPECT_GT(one.verdicts[std::size_t(Verdict::colliding)], 100u);
    for (const int size : {2, 4}) EXPECT_EQ(by_many(scene, size), one);
}

/// Bodies in heaps of very different density: the counted work is balanced, and the cuts do not affect results.
TEST_F(RanksTest, ClusteredScenesAreCutByWorkNotByBodies)
{
    Scene scene;
    scene.name = "clusters", scene.frames = 24; // the first cut is by bodies only
    const GeometryId ball = scene.add("ball", Sphere{0.4});
    for (std::uint64_t i = 0; i < 3000; ++i) {
        const double heap = std::floor(6 * u01(1, i, 0)), spread = 3 + 2 * heap;
        BodyInit body{.geometry = ball, .motion = Drift{.velocity = {0.02, 0, 0.01}, .walls = {}}};
        for (std::uint64_t k = 0; k < 3; ++k)
            body.pose.translation()[Eigen::Index(k)] =
                40 * u01(2, std::uint64_t(heap), k) + spread * (u01(3, i, k) + u01(4, i, k) - 1);
        scene.add_body(body);
    }
    const auto imbalance = [&](int size, Rebalance rebalance) {
        double result = 0;
        run_ranks_on_threads(size, [&](Ranks& ranks) {
            RankedRun run(ranks, make_morton_partitioner(), slice_of(scene, ranks.rank(), size, false), {},
                          {.rebalance = rebalance});
            while (run.frame() < scene.frames) run.step();
            double most = 0, all = 0;
            for (const RankStatistics& r : run.statistics(0))
                most = std::max(most, double(r.work)), all += double(r.work);
            if (ranks.rank() == 0) result = most * size / all;
        });
        return result;
    };
    for (const int size : {2, 4, 7}) EXPECT_LT(imbalance(size, Rebalance::automatic), 1.2) << size;
    EXPECT_GT(imbalance(7, Rebalance::never), 1.4);
}

// --- Faults: the tests above would detect them.

/// Morton's partitioner, with a fault.
class Faulty : public Partitioner {
public:
    void rebuild(Ranks& ranks, std::span<const Vector3d> points, std::span<const float> weights) override
    {
        good_->rebuild(ranks, points, weights);
        rank_ = ranks.rank();
    }
    int owner(const Vector3d& point) const override { return good_->owner(point); }
    void ranks(const Aabb& box, std::vector<int>& ranks) const override { good_->ranks(box, ranks); }

protected:
    std::unique_ptr<Partitioner> good_ = make_morton_partitioner();
    int rank_ = 0;
};

TEST_F(RanksTest, BoxesTakenAsOpenWouldLosePairs)
{
    struct Open : Faulty {
        void ranks(const Aabb& box, std::vector<int>& ranks) const override
        {
            good_->ranks({box.min + Vector3d::Constant(1e-9), box.max - Vector3d::Constant(1e-9)}, ranks);
        }
    };
    const Scene scene = lattice(7);
    EXPECT_NE(by_many(scene, 4, {}, {}, [] { return std::make_unique<Open>(); }), by_one(scene));
}

TEST_F(RanksTest, AGhostThatIsNotSentWouldLosePairs)
{
    struct Forgetful : Faulty {
        void ranks(const Aabb& box, std::vector<int>& ranks) const override
        {
            good_->ranks(box, ranks);
            if (ranks.size() > 1 && ++calls_ % 5 == 0) ranks.pop_back();
        }
        mutable int calls_ = 0;
    };
    const Scene scene = lattice(7);
    EXPECT_NE(by_many(scene, 4, {}, {}, [] { return std::make_unique<Forgetful>(); }), by_one(scene));
}

TEST_F(RanksTest, PairsThatNobodyOwnsAloneAreAnError)
{
    struct Everyone : Faulty {
        int owner(const Vector3d& point) const override
        {
            std::vector<int> all;
            good_->ranks({point - Vector3d::Ones(), point + Vector3d::Ones()}, all);
            return std::ranges::count(all, rank_) ? rank_ : all.front();
        }
    };
    try {
        by_many(lattice(5), 3, {}, {}, [] { return std::make_unique<Everyone>(); });
        ADD_FAILURE() << "no error";
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("decided by two processes"), std::string::npos) << error.what();
    }
}

TEST_F(RanksTest, RanksThatReadDifferentScenesSaySo)
{
    const Scene scene = balls(10, 1);
    const auto differs = [&](const std::function<void(Scene&)>& change) {
        expect_refused(ErrorKind::bad_data, "have read different scenes", [&] {
            run_ranks_on_threads(3, [&](Ranks& ranks) {
                Scene own = scene;
                if (ranks.rank() == 1) change(own);
                RankedRun run(ranks, make_morton_partitioner(), slice_of(own, ranks.rank(), 3, false), {});
            });
        });
    };
    differs([](Scene& own) { own = balls(10, 1 + 1e-9); });
    differs([](Scene& own) { own.set_layers(SceneBodyId{0}, 2, own.masks[0]); });
    differs([](Scene& own) { own.pace = 0.5; });
    differs([](Scene& own) { own.add("another", Sphere{2}); });
}

TEST_F(RanksTest, WhatDependsOnTheNumberOfProcessesIsRefused)
{
    const Scene scene = balls(10, 1);
    expect_refused(ErrorKind::usage, "--memory-budget", [&] { by_many(scene, 2, {.memory_budget = 1 << 20}); });
    expect_refused(ErrorKind::usage, "--skip broad", [&] { by_many(scene, 2, {.skip = {StageId::broad}}); });
    expect_refused(ErrorKind::usage, "--no-coherence", [&] { by_many(scene, 2, {}, {.separate = true}); });
}

TEST_F(RanksTest, AFaultOfOneRankIsAnErrorOfAll)
{
    expect_refused(ErrorKind::bad_data, "process 2 of 3: here", [&] {
        run_ranks_on_threads(3, [&](Ranks& ranks) {
            together(ranks, [&] {
                if (ranks.rank() == 2) throw Error(ErrorKind::bad_data, "here");
            });
        });
    });
    const auto leave = [](int i) { // leaves the world in frame 2
        return i == 3 ? Motion(Drift{.velocity = {9e14, 0, 0}, .walls = {}}) : of_every_second(i);
    };
    Scene scene = balls(6, 1, leave);
    expect_refused(ErrorKind::bad_data, "body 3: the pose is beyond 1e15 m", [&] { by_many(scene, 3); });
    EXPECT_TRUE(folder_.list().empty()) << "no half of a file is left";
}

TEST_F(RanksTest, ARunGoesOnFromItsCheckpointOnOtherRanks)
{
    Scene scene = catalogue_scene("boxes", 300, 9); // random walks: every frame depends on the one before
    const Played one = by_one(scene);
    for (const auto& [before, after] : {std::pair{3, 2}, {1, 4}, {4, 1}}) {
        RankedOptions options{.checkpoint = folder_ / "check", .checkpoint_every = 2};
        by_many(scene, before, {}, options, &make_morton_partitioner, 7); // frame 6 has a checkpoint, frame 7 is lost
        EXPECT_FALSE(std::filesystem::exists(folder_ / "many.csv")) << "not whole yet";
        options.resume = true;
        EXPECT_EQ(by_many(scene, after, {}, options), one);
        std::filesystem::remove(folder_ / "many.csv");
    }
}

TEST_F(RanksTest, ADamagedCheckpointGivesWayToTheOneBefore)
{
    Scene scene = catalogue_scene("boxes", 300, 9);
    const Played one = by_one(scene);
    RankedOptions options{.checkpoint = folder_ / "check", .checkpoint_every = 2};
    by_many(scene, 2, {}, options, &make_morton_partitioner, 7);
    options.resume = true;
    const auto damage = [&](const char* name, std::streamoff at) {
        std::fstream file(folder_ / name, std::ios::in | std::ios::out | std::ios::binary);
        file.seekp(at);
        file.put('x');
    };
    damage("check.0", 5000); // of frame 6
    EXPECT_EQ(by_many(scene, 3, {}, options), one);
    by_many(scene, 2, {}, {.checkpoint = folder_ / "check", .checkpoint_every = 2}, &make_morton_partitioner, 7);
    damage("check.0", 5000), damage("check.1", 20);
    expect_refused(ErrorKind::bad_data, "check", [&] { by_many(scene, 3, {}, options); });
}

TEST_F(RanksTest, ACheckpointOfAnotherSceneOrRunIsRefused)
{
    Scene scene = catalogue_scene("boxes", 300, 9);
    RankedOptions options{.checkpoint = folder_ / "check", .checkpoint_every = 2};
    by_many(scene, 2, {}, options, &make_morton_partitioner, 5);
    options.resume = true;
    expect_refused(ErrorKind::bad_data, "another scene",
                   [&] { by_many(catalogue_scene("boxes", 301, 9), 2, {}, options); });
    expect_refused(ErrorKind::bad_data, "other settings", [&] { by_many(scene, 2, {.clearance = 1}, options); });
    options.checkpoint = folder_ / "nowhere";
    expect_refused(ErrorKind::no_input, "there is no checkpoint", [&] { by_many(scene, 2, {}, options); });
}

} // namespace
} // namespace ranks_test
} // namespace oncollide
