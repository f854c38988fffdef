// Runs with bodies on their ways (--continuous) by many ranks: the results of one World, bit by bit.
#include <filesystem>

#include <oncollide/samples/generators.hpp>

#include "ranks_fixture.hpp"

namespace oncollide {
namespace ranks_test {
namespace {

class RankedWays : public RanksTest {
protected:
    /// Also for other numbers of threads.
    Played expect_the_same_ways(const Scene& scene, const Settings& settings = {})
    {
        const Played one = by_one(scene, settings, true);
        Settings threads = settings;
        threads.threads = 3;
        EXPECT_EQ(by_one(scene, threads, true), one) << scene.name;
        for (const int size : {1, 2, 3, 4})
            for (const Rebalance rebalance : {Rebalance::automatic, Rebalance::always, Rebalance::never}) {
                const Settings& how = size == 3 ? threads : settings;
                EXPECT_EQ(by_many(scene, size, how, {.rebalance = rebalance, .continuous = true}), one)
                    << size << " ranks, " << scene.name;
            }
        return one;
    }
};

/// Plates in a row, and small bodies that fly through regions of several ranks in one frame, some there and back.
Scene range()
{
    Scene scene;
    scene.name = "range", scene.frames = 6;
    const GeometryId plate = scene.add("plate", make_box_mesh({0.01, 1, 1})),
                     bullet = scene.add("bullet", make_sphere_mesh(0.02, 60)), ball = scene.add("ball", Sphere{0.02});
    for (int i = 0; i < 40; ++i) {
        BodyInit body{.geometry = plate, .is_static = i % 3 != 0};
        body.pose.translation() = Vector3d(2 * i, i % 5, 0);
        if (!body.is_static) body.motion = Drift{.velocity = {0.3, 0, 0}, .spin = {0, 0, 0.4}, .walls = {}};
        scene.add_body(body);
    }
    const Eigen::Quaterniond start(1, 0, 0, 0), turned(Eigen::AngleAxisd(2, Vector3d::UnitY()));
    for (int i = 0; i < 30; ++i) {
        const Vector3d from(-3 + 2.7 * i, 0.17 * i, 0.03 * (i - 15)), to(80 - from.x(), from.y(), 0);
        BodyInit body{.geometry = i % 2 ? bullet : ball};
        body.pose.translation() = from;
        if (i % 3)
            body.motion = Drift{.velocity = {i % 2 ? 37.0 : -45.0, 0.1, 0}, .spin = {0, 0.5, 0}, .walls = {}};
        else // within the frame from 2 to 3
            body.motion = Keyed{{{0, from, start}, {2.25, from, start}, {2.5, to, turned}, {2.75, from, start}}};
        scene.add_body(body);
    }
    return scene;
}

TEST_F(RankedWays, FastBodiesMeetOnTheirWaysAsInOneWorld)
{
    const Scene scene = range();
    const Played one = expect_the_same_ways(scene);
    EXPECT_GT(one.verdicts[std::size_t(Verdict::colliding)], 200u);
    EXPECT_LT(by_one(scene).verdicts[std::size_t(Verdict::colliding)], 50u);
    EXPECT_TRUE(one.csv.starts_with("frame,a,b,verdict,gap_bound,stage,kind,max_error,clear_until,"));
    expect_the_same_ways(scene, {.clearance = 0.05});
    expect_the_same_ways(scene, {.skip = {StageId::bounds}});
}

TEST_F(RankedWays, WaysOfTheCatalogueAreThoseOfOneWorld)
{
    const auto fast = [](Scene scene, double pace) { return scene.pace = pace, scene; };
    expect_the_same_ways(fast(catalogue_scene("city", 150, 4), 20));
    expect_the_same_ways(catalogue_scene("many", 60, 3));
    expect_the_same_ways(fast(catalogue_scene("octomap", 12, 3), 5));
    expect_the_same_ways(fast(catalogue_scene("hills", 30, 3), 5));
    expect_the_same_ways(fast(catalogue_scene("boxes", 400, 4), 3));
    expect_the_same_ways(catalogue_scene("hard", {}, 3));
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        SCOPED_TRACE(seed);
        expect_the_same_ways(make_scene("random", {.bodies = 30, .frames = 4, .seed = seed, .data = {}}),
                             {.exact = seed % 2 ? ExactLevel::predicates : ExactLevel::off});
    }
}

TEST_F(RankedWays, ARunWithWaysGoesOnFromItsCheckpoint)
{
    Scene scene = range();
    const Played one = by_one(scene, {}, true);
    for (const auto& [before, after] : {std::pair{3, 2}, {1, 4}}) {
        RankedOptions options{.continuous = true, .checkpoint = folder_ / "check", .checkpoint_every = 2};
        by_many(scene, before, {}, options, &make_morton_partitioner, 5);
        options.resume = true;
        options.continuous = false;
        expect_refused(ErrorKind::bad_data, "other settings", [&] { by_many(scene, after, {}, options); });
        options.continuous = true;
        EXPECT_EQ(by_many(scene, after, {}, options), one);
        std::filesystem::remove(folder_ / "many.csv");
    }
}

} // namespace
} // namespace ranks_test
} // namespace oncollide
