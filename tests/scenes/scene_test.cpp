#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "same_scene.hpp"
#include "test_files.hpp"
#include <oncollide/samples/generators.hpp>

#include "count_allocations.hpp"

namespace oncollide {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using test::expect_error;

Isometry3d at(double x, double y, double z)
{
    Isometry3d pose = Isometry3d::Identity();
    pose.translation() = Vector3d(x, y, z);
    return pose;
}

Scene scene_with_ball()
{
    Scene scene;
    scene.add("ball", Sphere{1});
    return scene;
}

TEST(Scene, KeepsWhatWasAddedInColumnsOfOneLength)
{
    Scene scene;
    const GeometryId ball = scene.add("ball", Sphere{1});
    const GeometryId box = scene.add("box", make_box_mesh({1, 2, 3}), "recipe");
    scene.add_body({.name = "a", .geometry = box, .pose = at(1, 2, 3), .is_static = true, .layer = 4, .mask = 8});
    const SceneBodyId b = scene.add_body({.name = "b", .geometry = ball, .motion = Drift{}});
    EXPECT_EQ(scene.size(), 2u);
    EXPECT_EQ(index(b), 1u);
    for (const std::size_t length : {scene.geometry.size(), scene.poses.size(), scene.names.size(),
                                     scene.is_static.size(), scene.layers.size(), scene.masks.size()})
        EXPECT_EQ(length, 2u);
    EXPECT_EQ(scene.geometries[1].recipe, "recipe");
    EXPECT_EQ(scene.geometry[0], box);
    EXPECT_EQ(scene.poses[0].translation(), Vector3d(1, 2, 3));
    EXPECT_EQ(scene.start_pose(0).translation(), Vector3d(1, 2, 3));
    EXPECT_TRUE(scene.is_static[0]);
    EXPECT_EQ(scene.layers[0], 4u);
    EXPECT_EQ(scene.masks[0], 8u);
    EXPECT_EQ(scene.layers[1], 1u);
    EXPECT_EQ(scene.masks[1], 0xffffffffu);
    EXPECT_EQ(bounds_of(scene.geometries[1]).max, Vector3d(1, 2, 3));
    EXPECT_EQ(bounds_of(scene.geometries[0]).min, Vector3d(-1, -1, -1));
}

TEST(Scene, FindsBodiesAndGeometriesByName)
{
    Scene scene = scene_with_ball();
    for (int i = 0; i < 100; ++i) scene.add_body({.name = "body " + std::to_string(i)});
    EXPECT_EQ(scene.find("body 42"), SceneBodyId{42});
    EXPECT_EQ(scene.find("body 100"), std::nullopt);
    EXPECT_EQ(scene.find_geometry("ball"), GeometryId{0});
    EXPECT_EQ(scene.find_geometry("body 42"), std::nullopt);
    const Scene copy = scene;
    scene = {};
    EXPECT_EQ(copy.find("body 7"), SceneBodyId{7});
    EXPECT_EQ(scene.find("body 7"), std::nullopt);
}

TEST(Scene, RefusesASecondGeometryOrBodyOfTheSameName)
{
    Scene scene = scene_with_ball();
    expect_error(
        ErrorKind::bad_data, [&] { scene.add("ball", Sphere{2}); }, "geometry 'ball'", "another geometry");
    scene.add_body({.name = "a"});
    expect_error(
        ErrorKind::bad_data, [&] { scene.add_body({.name = "a"}); }, "body 'a'", "another body");
    EXPECT_EQ(scene.geometries.size(), 1u);
    EXPECT_EQ(scene.size(), 1u);
}

TEST(Scene, TakesANameAgainAfterItWasRefusedForAnotherReason)
{
    Scene scene = scene_with_ball();
    expect_error(
        ErrorKind::bad_data, [&] { scene.add_body({.name = "a", .pose = at(NAN, 0, 0)}); }, "not finite");
    EXPECT_NO_THROW(scene.add_body({.name = "a"}));
}

TEST(Scene, KeepsAReferenceToAGeometryGoodWhenOthersAreAdded)
{
    std::shared_ptr<const Geometry> shared;
    {
        Scene scene;
        scene.add("box", make_box_mesh({1, 2, 3}));
        const Geometry& box = scene.geometries[0];
        const Mesh& mesh = std::get<Mesh>(box.data);
        for (int i = 0; i < 1000; ++i) scene.add(std::to_string(i), Sphere{1});
        EXPECT_EQ(box.name, "box");
        EXPECT_EQ(mesh.bounds.max, Vector3d(1, 2, 3));
        EXPECT_EQ(&box, &scene.geometries[0]);
        const Scene copy = scene;
        EXPECT_EQ(&box, &copy.geometries[0]) << "copies share their geometries";
        shared = scene.geometries.share(0);
        EXPECT_EQ(shared.get(), &box);
        EXPECT_EQ(std::distance(scene.geometries.begin(), scene.geometries.end()), 1001);
    }
    EXPECT_EQ(std::get<Mesh>(shared->data).triangles.size(), 12u) << "and it outlives the scene";
}

TEST(Scene, TakesManyBodiesWithoutNames)
{
    Scene scene = scene_with_ball();
    for (int i = 0; i < 3; ++i) scene.add_body({});
    scene.add_body({.name = "a"});
    EXPECT_EQ(scene.find(""), std::nullopt);
    EXPECT_EQ(scene.find("a"), SceneBodyId{3}) << "by its index, not by the number of named bodies";
    EXPECT_EQ(scene.label(SceneBodyId{2}), "body 2");
    EXPECT_EQ(scene.label(SceneBodyId{3}), "a");
    expect_error(
        ErrorKind::bad_data, [&] { scene.add_body({.pose = at(NAN, 0, 0)}); }, "body 4: ", "not finite");
}

TEST(Scene, KeepsGroupsAndExcludedPairs)
{
    Scene scene = scene_with_ball();
    for (std::uint32_t i = 0; i < 4; ++i) scene.add_body({.group = i / 2});
    EXPECT_TRUE(std::ranges::equal(scene.groups, std::vector<std::uint32_t>{0, 0, 1, 1}));
    scene.exclude(SceneBodyId{3}, SceneBodyId{1});
    scene.exclude(SceneBodyId{0}, SceneBodyId{1});
    EXPECT_EQ(scene.excluded, (std::vector<ExcludedPair>{{1, 3}, {0, 1}}));
    const auto refuses = [&](SceneBodyId a, SceneBodyId b, const char* what) {
        expect_error(
            ErrorKind::bad_data, [&] { scene.exclude(a, b); }, "exclude: ", what);
    };
    refuses(SceneBodyId{0}, SceneBodyId{4}, "there is no body 4; the scene has 4 bodies");
    refuses(SceneBodyId{2}, SceneBodyId{2}, "body 2 with itself");
    EXPECT_EQ(scene.excluded.size(), 2u);
}

TEST(Scene, RefusesAShapeWithoutSize)
{
    Scene scene;
    expect_error(
        ErrorKind::bad_data, [&] { scene.add("dot", Sphere{0}); }, "dot");
    EXPECT_TRUE(scene.geometries.empty());
}

TEST(Scene, RefusesAnUnknownGeometry)
{
    Scene scene = scene_with_ball();
    expect_error(
        ErrorKind::bad_data, [&] { scene.add_body({.name = "a", .geometry = GeometryId{1}}); }, "body 'a'",
        "geometry number 1");
}

TEST(Scene, RefusesAStaticBodyThatMoves)
{
    Scene scene = scene_with_ball();
    expect_error(
        ErrorKind::bad_data, [&] { scene.add_body({.name = "a", .motion = Drift{}, .is_static = true}); }, "body 'a'",
        "static");
}

TEST(Scene, RefusesPosesThatAreNotRigid)
{
    Scene scene = scene_with_ball();
    const auto refuses = [&](const Isometry3d& pose, const char* word) {
        expect_error(
            ErrorKind::bad_data, [&] { scene.add_body({.name = "a", .pose = pose}); }, "body 'a'", word);
    };
    refuses(at(INFINITY, 0, 0), "not finite");
    Isometry3d pose = at(0, 0, 0);
    pose.matrix()(1, 1) = NAN;
    refuses(pose, "not finite");
    pose = at(0, 0, 0);
    pose.linear() *= 1 + 1e-6;
    refuses(pose, "not rigid");
    pose = at(0, 0, 0);
    pose.linear()(0, 1) = 1e-5;
    refuses(pose, "not rigid");
    pose = at(0, 0, 0);
    pose.linear()(2, 2) = -1;
    refuses(pose, "mirrors");
    pose = at(0, 0, 0);
    pose.matrix()(3, 0) = 1;
    refuses(pose, "last row");
    pose = at(0, 0, 0);
    pose.linear() *= 1 + 1e-8; // as if by rounding to a float pose
    EXPECT_NO_THROW(scene.add_body({.name = "a", .pose = pose}));
}

TEST(Scene, RefusesAMotionWithoutMeaning)
{
    Scene scene = scene_with_ball();
    expect_error(
        ErrorKind::bad_data, [&] { scene.add_body({.name = "a", .motion = Keyed{}}); }, "body 'a'", "no key");
}

Scene moving_scene()
{
    Scene scene = scene_with_ball();
    const Aabb walls{{0, 0, 0}, {4, 4, 4}};
    scene.add_body({.name = "still", .pose = at(1, 1, 1)});
    scene.add_body({.name = "drift", .pose = at(1, 2, 3), .motion = Drift{{0.5, 0.25, -1}, {0, 0.1, 0}, walls}});
    scene.add_body({.name = "walk", .pose = at(2, 2, 2), .motion = Jitter{0.5, 9, 1, walls}});
    scene.add_body({.name = "walk 2", .pose = at(2, 2, 2), .motion = Jitter{0.5, 9, 2, walls}});
    scene.add_body({.name = "keyed",
                    .motion = Keyed{{{0, {0, 0, 0}, Eigen::Quaterniond::Identity()},
                                     {50, {5, 0, 0}, Eigen::Quaterniond(0, 1, 0, 0)}}}});
    return scene;
}

TEST(Mover, ReachesTheSamePosesInOneLeapAndStepByStep)
{
    Scene stepped = moving_scene(), leaping = moving_scene();
    Mover step, leap;
    for (int frame = 0; frame <= 40; ++frame) step.move(stepped, frame);
    leap.move(leaping, 40);
    test::expect_same_poses(stepped, leaping, "at frame 40");
    EXPECT_NE(stepped.poses[2].translation(), stepped.start_pose(2).translation());
    EXPECT_NE(stepped.poses[2].translation(), stepped.poses[3].translation()) << "two random walks must differ";
    EXPECT_EQ(stepped.poses[0].matrix(), stepped.start_pose(0).matrix());
}

TEST(Mover, PlaysAHalfOfTheMotionAtHalfThePace)
{
    Scene whole = moving_scene(), half = moving_scene();
    half.pace = 0.5;
    Mover a, b, c, d;
    a.move(whole, 7), b.move(half, 14);
    for (std::size_t i = 0; i < whole.size(); ++i)
        if (!std::holds_alternative<Jitter>(whole.motions[i])) {
            EXPECT_TRUE(whole.poses[i].isApprox(half.poses[i], 1e-12)) << i;
        }
    EXPECT_FALSE(whole.poses[1].isApprox(whole.start_pose(1), 1e-3));
    c.move(whole, 1), d.move(half, 1);
    const auto step = [](const Scene& scene) {
        return Vector3d(scene.poses[2].translation() - scene.start_pose(2).translation());
    };
    EXPECT_TRUE(step(half).isApprox(0.5 * step(whole), 1e-12)) << "a random walk takes steps of half the length";
}

TEST(Mover, WalksAgainFromTheStartWhenTimeRunsBackwards)
{
    Scene there_and_back = moving_scene(), direct = moving_scene();
    Mover mover, once;
    for (const int frame : {30, 31, 12}) mover.move(there_and_back, frame);
    once.move(direct, 12);
    test::expect_same_poses(there_and_back, direct, "at frame 12");
    mover.move(there_and_back, 12);
    test::expect_same_poses(there_and_back, direct, "at frame 12 again");
    mover.move(there_and_back, 0);
    EXPECT_EQ(there_and_back.poses[2].matrix(), there_and_back.start_pose(2).matrix());
}

TEST(Mover, StartsFromTheStartPosesWhateverThePosesWere)
{
    Scene scene = moving_scene();
    for (std::uint32_t i = 1; i < scene.size(); ++i)
        scene.set_position(SceneBodyId{i}, scene.poses.position(i) + Vector3d(3, 3, 3));
    const Eigen::Matrix4d first = scene.poses[0].matrix();
    Mover().move(scene, 0);
    for (std::size_t i = 1; i < scene.size(); ++i)
        EXPECT_EQ(scene.poses[i].matrix(), scene.start_pose(i).matrix()) << scene.names[i];
    EXPECT_EQ(scene.poses[0].matrix(), first);
    scene.set_position(SceneBodyId{0}, {3, 3, 3});
    Mover().move(scene, 1);
    EXPECT_EQ(scene.poses[0].translation(), Vector3d(3, 3, 3)) << "a body without motion belongs to the caller";
}

TEST(Mover, AllocatesNothingAfterTheFirstCall)
{
    Scene scene = moving_scene();
    Mover mover;
    mover.move(scene, 0);
    const std::size_t before = allocations;
    for (int frame = 1; frame < 100; ++frame) mover.move(scene, frame);
    mover.move(scene, 3);
    EXPECT_EQ(allocations - before, 0u);
}

} // namespace
} // namespace oncollide
