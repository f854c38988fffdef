// Sweeps past gaps that rounding hides, and which contacts end a sweep.
#include <gtest/gtest.h>

#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>

#include "verify/trials/graze_trial.hpp"

namespace oncollide {
namespace grazing_sweeps_test {
namespace {

using Eigen::Isometry3d, Eigen::Vector3d;

Isometry3d at(double x, double y, double z)
{
    Isometry3d pose = Isometry3d::Identity();
    pose.translation() = Vector3d(x, y, z);
    return pose;
}

/// A floor of 20 m whose top is z = 0, and a wall on it from x = 2.9 on, as one mesh.
Mesh make_room()
{
    std::vector<Vector3d> vertices;
    std::vector<Triangle> triangles;
    for (const auto& [half, centre] :
         {std::pair(Vector3d(10, 10, 0.5), Vector3d(0, 0, -0.5)), std::pair(Vector3d(0.1, 5, 2), Vector3d(3, 0, 2))}) {
        const Mesh box = make_box_mesh(half);
        for (Triangle t : box.triangles) {
            for (auto& v : t) v += static_cast<std::uint32_t>(vertices.size());
            triangles.push_back(t);
        }
        for (const Vector3d& v : box.vertices) vertices.push_back(v + centre);
    }
    return make_mesh("room", std::move(vertices), std::move(triangles));
}

class Room : public testing::Test {
protected:
    SweepResult slide(ModelId body, double gap, SweepStop stop, bool swap)
    {
        const MovingModel moves{body, {at(-5, 0, 0.5 + gap), at(5, 0, 0.5 + gap)}}, rests{room, {at(0, 0, 0)}};
        return swap ? world.pairs().sweep(rests, moves, {.stop = stop})
                    : world.pairs().sweep(moves, rests, {.stop = stop});
    }
    World world;
    const ModelId room = world.models().add(make_room()), box = world.models().add(Shape(Box{{0.5, 0.5, 0.5}})),
                  mesh = world.models().add(make_box_mesh({0.5, 0.5, 0.5})),
                  ball = world.models().add(Shape(Sphere{0.5}));
};

TEST_F(Room, ABodyThatSlidesOverTheFloorMeetsTheWall)
{
    for (const ModelId body : {box, mesh, ball})
        for (const double gap : {1e-14, 1e-13, 1e-12, 1e-11, 1e-10, 2e-10, 1e-8})
            for (const bool swap : {false, true}) {
                const SweepResult r = slide(body, gap, SweepStop::contact, swap);
                if (gap == 1e-14 && r.contact_by == 0) continue; // rounding may let it touch the floor
                EXPECT_EQ(r.verdict, Verdict::colliding) << gap;
                EXPECT_NEAR(r.contact_by, 0.74, 1e-4) << gap;
                EXPECT_LE(r.contact_by - r.grazes_until, 1e-4);
                EXPECT_LE(r.clear_until, 0.74);
                EXPECT_LE(r.gap, 1e-4 * (1 + 1e-3));
                EXPECT_LT((r.normal - Vector3d(swap ? -1 : 1, 0, 0)).norm(), 1e-6) << gap << r.normal.transpose();
                if (gap >= 1e-11) {
                    EXPECT_NEAR(r.clear_until, 0.74, 1e-4) << "certified";
                }
            }
}

TEST_F(Room, ASweepThatStopsAtATouchEndsAtAHiddenGap)
{
    for (const bool swap : {false, true}) {
        const SweepResult r = slide(box, 1e-13, SweepStop::touch, swap);
        EXPECT_EQ(r.verdict, Verdict::within);
        EXPECT_EQ(r.contact_by, r.clear_until);
        EXPECT_LT(r.gap, 1e-9);
        EXPECT_TRUE(r.normal.isZero(0)) << "it would belong to any of two";
    }
}

TEST_F(Room, ABodyThatRestsOnTheFloorSlidesUntilItPressesAgainstTheWall)
{
    for (const ModelId body : {box, mesh, ball})
        for (const double gap : {0.0, 1e-13, -1e-6, -2e-5}) // on the floor, above and in it
            for (const bool swap : {false, true}) {
                const SweepResult r = slide(body, gap, SweepStop::press, swap);
                EXPECT_EQ(r.verdict, Verdict::colliding) << gap;
                EXPECT_NEAR(r.contact_by, 0.74, 1e-4) << gap;
                EXPECT_LT((r.normal - Vector3d(swap ? -1 : 1, 0, 0)).norm(), 1e-6) << gap;
            }
    EXPECT_EQ(slide(box, -1e-3, SweepStop::press, false).contact_by, 0) << "deeper than the gap tolerance";
    EXPECT_EQ(slide(box, 0, SweepStop::contact, false).contact_by, 0);
}

TEST_F(Room, BodiesThatPartAreNoContactThatPresses)
{
    const MovingModel lifts{box, {at(0, 0, 0.5), at(0, 0, 2)}}, falls{box, {at(0, 0, 0.5), at(0, 0, 0.4)}},
        rests{room, {at(0, 0, 0)}};
    const SweepResult up = world.pairs().sweep(lifts, rests, {.stop = SweepStop::press}),
                      down = world.pairs().sweep(falls, rests, {.stop = SweepStop::press});
    EXPECT_EQ(up.verdict, Verdict::within);
    EXPECT_EQ(up.clear_until, 0) << "they touch";
    EXPECT_EQ(up.grazes_until, 1);
    EXPECT_EQ(down.verdict, Verdict::colliding);
    EXPECT_GT(down.contact_by, 0);
    EXPECT_LT(down.contact_by, 3e-3);
}

TEST(GrazingSweeps, ABallFallsOntoPlatesOfAnySize)
{
    for (const auto& [half, tolerance] : {std::pair(1e3, 1e-9), std::pair(1e7, 1e-4)})
        for (const bool as_mesh : {false, true}) {
            World world;
            const ModelId ball = world.models().add(Shape(Sphere{0.5})),
                          plate = as_mesh ? world.models().add(make_box_mesh({half, half, 0.5}))
                                          : world.models().add(Shape(Box{{half, half, 0.5}}));
            const MovingModel falls{ball, {at(0.1, 0.2, 5), at(0.1, 0.2, -5)}}, rests{plate, {at(0, 0, 0)}};
            const SweepOptions options{.time_tolerance = tolerance, .gap_tolerance = tolerance};
            for (const SweepResult& r :
                 {world.pairs().sweep(falls, rests, options), world.pairs().sweep(rests, falls, options)}) {
                EXPECT_EQ(r.verdict, Verdict::colliding) << half;
                EXPECT_LE(r.clear_until, 0.4);
                EXPECT_NEAR(r.contact_by, 0.4, tolerance) << half;
                EXPECT_LE(r.gap, tolerance * (1 + 1e-3)) << half;
            }
        }
}

TEST(GrazingSweeps, ACastPassesTheFloorAndFindsTheWall)
{
    World world;
    const ModelId box = world.models().add(Shape(Box{{0.5, 0.5, 0.5}}));
    const BodyId floor = world.bodies().add(
                     {.model = world.models().add(make_box_mesh({10, 10, 0.5})), .pose = at(0, 0, -0.5)}),
                 wall =
                     world.bodies().add({.model = world.models().add(make_box_mesh({0.1, 5, 2})), .pose = at(3, 0, 2)});
    world.step();
    const MovingModel slides{box, {at(-5, 0, 0.5 + 1e-13), at(5, 0, 0.5 + 1e-13)}},
        rests{box, {at(-5, 0, 0.5), at(5, 0, 0.5)}}, lifts{box, {at(-5, 0, 0.5), at(-5, 0, 3)}};
    const SweepHit hit = world.space().cast(slides), touch = world.space().cast(slides, {}, {.stop = SweepStop::touch}),
                   press = world.space().cast(rests, {}, {.stop = SweepStop::press});
    EXPECT_EQ(hit.body, wall);
    EXPECT_EQ(hit.clear_until, 0) << "the floor";
    EXPECT_NEAR(hit.contact_by, 0.74, 1e-4);
    EXPECT_NEAR(hit.grazes_until, 0.74, 1e-4);
    EXPECT_EQ(touch.body, floor);
    EXPECT_EQ(press.body, wall);
    EXPECT_NEAR(press.contact_by, 0.74, 1e-4);
    EXPECT_EQ(world.space().cast(rests).body, floor);
    EXPECT_EQ(world.space().cast(lifts, {}, {.stop = SweepStop::press}).verdict, Verdict::separate);
    EXPECT_TRUE(world.space().cast_all(lifts, {}, {.stop = SweepStop::press}).empty());
}

TEST(GrazingSweeps, AStepTakesTheSameOptionsOnAnyNumberOfThreads)
{
    for (const SweepStop stop : {SweepStop::contact, SweepStop::touch, SweepStop::press}) {
        std::uint64_t hash = 0;
        for (const int threads : {1, 3}) {
            World world({.threads = threads});
            const ModelId box = world.models().add(Shape(Box{{0.5, 0.5, 0.5}}));
            world.bodies().add({.model = world.models().add(make_room()), .is_static = true});
            world.set_sweep_options({.stop = stop});
            for (int i = 0; i < 3; ++i) {
                const BodyId body = world.bodies().add({.model = box, .pose = at(-5, 2.0 * i - 2, 0.5 + 1e-13)});
                world.bodies().set_motion(body, at(5, 2.0 * i - 2, 0.5 + 1e-13));
            }
            const FrameView frame = world.step();
            EXPECT_EQ(frame.sweeps.size(), 3u);
            for (const PairSweep& sweep : frame.sweeps) {
                EXPECT_EQ(sweep.verdict, stop == SweepStop::touch ? Verdict::within : Verdict::colliding);
                EXPECT_EQ(frame.pairs[sweep.pair].verdict, sweep.verdict);
            }
            if (threads == 1) hash = frame.hash;
            EXPECT_EQ(frame.hash, hash);
        }
    }
}

TEST(GrazingSweeps, OfAllScalesAgreeWithClosedForms)
{
    const tools::GrazeTally all = tools::try_grazes(1, 8'000, 1, [] {});
    EXPECT_EQ(all.first.what, "") << "seed " << all.first.seed << "; " << all.faults << " in all";
    EXPECT_EQ(all.sweeps, 8'000u);
    EXPECT_GT(all.contacts, 1600u);
    EXPECT_GT(all.grazes, 400u);
    EXPECT_GT(all.clear, 400u);
}

} // namespace
} // namespace grazing_sweeps_test
} // namespace oncollide
