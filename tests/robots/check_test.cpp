// Robot::check() against every pair decided alone by the World, without bounding spheres, solids, batches or early
// stops.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "random_pose.hpp"
#include "robots/long_arm.hpp"
#include "robots/small_robot.hpp"
#include <oncollide/robots/part_solids.hpp>
#include <oncollide/robots/robot.hpp>
#include <oncollide/samples/generators.hpp>

namespace oncollide::robot_check_test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using test::add_bodies, test::long_arm, test::numbers_of, test::random_numbers, test::SmallRobot;

/// The worst finding of the environment: the last part first, then the least slot.
RobotFinding alone(const World& world, const RobotDescription& robot, std::span<const ModelId> models,
                   std::span<const Isometry3d> links)
{
    RobotFinding worst;
    std::size_t part = models.size();
    for (auto link = static_cast<std::uint32_t>(robot.links.size()); link-- > 0;)
        for (std::size_t k = robot.links[link].collision.size(); k-- > 0;) {
            --part;
            for (std::uint32_t slot = 0; slot < world.bodies().size(); ++slot) {
                const PlacedModel placed{models[part], links[link] * robot.links[link].collision[k].pose};
                const Finding found = world.pairs().decide(placed, world.bodies().at(slot));
                if (found.verdict == Verdict::colliding)
                    return {found.bound, found.verdict, link, RobotFinding::no_link, world.bodies().at(slot)};
                if (found.verdict != Verdict::separate && worst.verdict == Verdict::separate)
                    worst = {found.bound, found.verdict, link, RobotFinding::no_link, world.bodies().at(slot)};
            }
        }
    return worst;
}

TEST(RobotCheck, FindsTheFirstPairThatEveryPairDecidedAloneShows)
{
    const RobotDescription description = long_arm();
    for (const auto& [bodies, reach] : {std::pair<std::size_t, double>{12, 1.3}, {150, 3.5}}) { // 150: not together
        World world;
        add_bodies(world, bodies, reach, bodies);
        const Robot robot(world, description, random_pose(3, 0.2));
        std::vector<ModelId> models;
        for (const RobotLink& link : description.links)
            for (const LinkGeometry& collision : link.collision)
                models.push_back(world.models().add(collision.geometry));
        std::size_t colliding = 0;
        constexpr std::size_t count = 150;
        for (const double step : {0.1, 1.0}) {
            const std::vector<double> numbers = numbers_of(robot, count, step);
            std::vector<RobotFinding> found(count);
            robot.check(world, numbers, found, {.self = false});
            std::vector<Isometry3d> links(description.links.size());
            for (std::size_t i = 0; i < count; ++i) {
                robot.link_poses(std::span(numbers).subspan(i * robot.width(), robot.width()), links);
                const RobotFinding expected = alone(world, description, models, links);
                ASSERT_EQ(found[i].verdict, expected.verdict) << i;
                EXPECT_EQ(found[i].bound, expected.bound) << i;
                EXPECT_EQ(found[i].link, expected.link) << i;
                EXPECT_EQ(found[i].body, expected.body) << i;
                colliding += found[i].verdict == Verdict::colliding;
            }
        }
        EXPECT_GT(colliding, 20u);
        EXPECT_LT(colliding, 2 * count - 20);
    }
}

/// A ball that slides along a row of boxes, at places where it just meets one or just does not.
TEST(RobotCheck, NoContactIsLostAmongManyBodies)
{
    RobotDescription slider;
    slider.name = "slider";
    slider.links = {{"root", {}}, {"ball", {{std::make_shared<const Geometry>(Geometry{"ball", Sphere{0.05}, {}})}}}};
    RobotJoint joint;
    joint.name = "slide", joint.kind = JointKind::prismatic, joint.child = 1;
    slider.joints = {joint};
    World world;
    const Robot robot(world, slider, Isometry3d(Eigen::Translation3d(5, 6, 7)));
    const ModelId box = world.models().add(Box{{0.01, 0.01, 0.01}});
    for (int i = 0; i < 100; ++i)
        world.bodies().add({.model = box, .pose = Isometry3d(Eigen::Translation3d(5 + 0.25 * i, 6, 7))});
    std::vector<double> numbers;
    for (const double from : {-0.06 - 1e-9, -0.06 + 1e-9, 0.06 - 1e-9, 0.06 + 1e-9})
        for (int i = 0; i < 100; ++i) numbers.push_back(0.25 * i + from);
    std::vector<RobotFinding> found(numbers.size());
    robot.check(world, numbers, found);
    for (std::size_t i = 0; i < found.size(); ++i)
        EXPECT_EQ(found[i].verdict == Verdict::colliding, i / 100 == 1 || i / 100 == 2) << i;
}

TEST(RobotCheck, SelfCollisionsAreThoseOfEveryPairDecidedAlone)
{
    const RobotDescription description = long_arm();
    World world;
    const Robot robot(world, description, random_pose(3, 0.2));
    std::vector<std::pair<std::uint32_t, ModelId>> models;
    std::vector<Isometry3d> at;
    for (std::uint32_t link = 0; link < description.links.size(); ++link)
        for (const LinkGeometry& collision : description.links[link].collision)
            models.push_back({link, world.models().add(collision.geometry)}), at.push_back(collision.pose);
    constexpr std::size_t count = 200;
    const std::vector<double> numbers = numbers_of(robot, count, 1);
    std::vector<RobotFinding> found(count);
    robot.check(world, numbers, found);
    std::vector<Isometry3d> links(description.links.size());
    std::size_t colliding = 0;
    for (std::size_t i = 0; i < count; ++i) {
        robot.link_poses(std::span(numbers).subspan(i * robot.width(), robot.width()), links);
        std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
        for (std::size_t b = 0; b < models.size(); ++b)
            for (std::size_t a = 0; a < b; ++a) {
                const std::pair<std::uint32_t, std::uint32_t> pair{models[a].first, models[b].first};
                if (pair.second - pair.first < 2) continue;
                const Finding alone = world.pairs().decide(PlacedModel{models[a].second, links[pair.first] * at[a]},
                                                           PlacedModel{models[b].second, links[pair.second] * at[b]});
                if (alone.verdict == Verdict::colliding) pairs.push_back(pair);
            }
        ASSERT_EQ(found[i].verdict == Verdict::colliding, !pairs.empty()) << i;
        if (pairs.empty()) continue;
        ++colliding;
        EXPECT_TRUE(std::ranges::count(pairs, std::pair(found[i].link, found[i].other))) << i;
    }
    EXPECT_GT(colliding, 10u);
    EXPECT_LT(colliding, count - 10);
}

TEST(RobotCheck, OneConfigurationAtATimeAndThreadsGiveTheSame)
{
    World world, threaded({.threads = 3});
    add_bodies(world, 20, 1.6, 9), add_bodies(threaded, 20, 1.6, 9);
    const RobotDescription description = long_arm();
    const Robot robot(world, description), other(threaded, description);
    constexpr std::size_t count = 700;
    const std::vector<double> numbers = numbers_of(robot, count, 0.3);
    std::vector<RobotFinding> found(count), parallel(count), single(1);
    robot.check(world, numbers, found);
    other.check(threaded, numbers, parallel);
    const auto expect_equal = [](const RobotFinding& a, const RobotFinding& b, std::size_t i) {
        EXPECT_EQ(a.verdict, b.verdict) << i;
        EXPECT_EQ(a.bound, b.bound) << i;
        EXPECT_EQ(std::tuple(a.link, a.other, a.body.slot), std::tuple(b.link, b.other, b.body.slot)) << i;
    };
    for (std::size_t i = 0; i < count; ++i) {
        robot.check(world, std::span(numbers).subspan(i * robot.width(), robot.width()), single);
        expect_equal(found[i], single[0], i), expect_equal(found[i], parallel[i], i);
    }
}

/// A robot keeps working memory between calls, and the World changes.
TEST(RobotCheck, BodiesThatMoveComeAndGoAreSeen)
{
    SmallRobot files;
    World world;
    const Robot robot(world,
                      load_robot(files.urdf, {.srdf = files.srdf, .packages = {{"robot", files.folder().path()}}}));
    const std::vector<double> q{0, 0, 0.05};
    std::vector<RobotFinding> found(1);
    const auto verdict = [&] { return robot.check(world, q, found), found[0].verdict; };
    EXPECT_EQ(verdict(), Verdict::separate);
    const BodyId body = world.bodies().add({.model = world.models().add(Box{{0.1, 0.1, 0.1}})});
    EXPECT_EQ(verdict(), Verdict::colliding);
    EXPECT_EQ(found[0].body, body);
    world.bodies().set_pose(body, Isometry3d(Eigen::Translation3d(3, 0, 0)));
    EXPECT_EQ(verdict(), Verdict::separate);
    world.bodies().set_pose(body, Isometry3d::Identity());
    robot.check(world, q, found, {.filter = {.mask = 2}});
    EXPECT_EQ(found[0].verdict, Verdict::separate);
    EXPECT_EQ(verdict(), Verdict::colliding);
    world.bodies().remove(body);
    EXPECT_EQ(verdict(), Verdict::separate);
}

TEST(RobotCheck, PosesThatALongChainMakesUnsoundAreRefused)
{
    RobotDescription chain;
    chain.name = "chain";
    chain.links.resize(12);
    for (std::uint32_t i = 0; i + 1 < chain.links.size(); ++i) {
        chain.links[i].name = "link" + std::to_string(i);
        RobotJoint joint;
        joint.name = "joint" + std::to_string(i);
        joint.parent = i, joint.child = i + 1, joint.origin.linear() *= 1 + 4e-7; // each is accepted
        chain.joints.push_back(joint);
    }
    chain.links.back() = {"last", {{std::make_shared<const Geometry>(Geometry{"ball", Sphere{0.1}, {}})}}};
    World world;
    world.bodies().add({.model = world.models().add(Sphere{0.1})});
    const Robot robot(world, chain);
    std::vector<RobotFinding> found(1);
    try {
        robot.check(world, {}, found);
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::bad_data);
        EXPECT_NE(std::string(error.what()).find("configuration 0: link 'last'"), std::string::npos) << error.what();
    }
}

/// Solids of meshes give the verdicts of the exact decision.
TEST(PartSolids, TellThatPartsAreApartOrMeetOnlyWhereTheyDo)
{
    const Mesh knot = make_torus_knot_mesh(2, 3, 0.3, 0.12, 0.06, 800), block = make_box_mesh({0.3, 0.2, 0.1});
    const PartSolids of_knot(knot), of_block(block);
    const std::vector<Shape> shapes{Box{{0.5, 0.4, 0.02}}, Box{{0.02, 0.02, 0.02}}, Cylinder{0.1, 0.5},
                                    Cylinder{0.4, 0.05}, Sphere{0.2}};
    for (const double clearance : {0.0, 0.03}) {
        World world({.clearance = clearance, .exact = ExactLevel::predicates});
        const ModelId knot_model = world.models().add(knot), block_model = world.models().add(block);
        std::size_t apart = 0, together = 0, parted = 0;
        Parting parting;
        for (std::uint64_t seed = 0; seed < 3000; ++seed) {
            const bool is_knot = seed % 2;
            const PartSolids& solids = is_knot ? of_knot : of_block;
            const Isometry3d pose = random_pose(seed, 0.5), other = random_pose(seed + 10'000, 0.3);
            const PlacedModel placed{is_knot ? knot_model : block_model, pose};
            const Shape& shape = shapes[seed % shapes.size()];
            const Geometry geometry{"body", shape, {}};
            const PlacedBody body(0, geometry, bounds_of(geometry), other);
            const ModelId model = world.models().add(shape);
            const Verdict truth = world.pairs().decide(placed, PlacedModel{model, other}).verdict;
            world.models().remove(model);
            if (surely_apart(solids, pose, body.box, clearance)) {
                EXPECT_EQ(truth, Verdict::separate) << seed;
                ++apart;
            }
            if (surely_meet(solids, pose, body)) {
                EXPECT_EQ(truth, Verdict::colliding) << seed;
                ++together;
            }
            if (surely_apart(solids, pose, of_block, other, clearance, parting)) {
                EXPECT_EQ(world.pairs().decide(placed, PlacedModel{block_model, other}).verdict, Verdict::separate)
                    << seed;
                ++parted;
            }
        }
        EXPECT_GT(apart, 500u);
        EXPECT_GT(together, 300u);
        EXPECT_GT(parted, 100u);
    }
}

/// A small box inside a closed mesh meets its inner balls, but not its surface.
TEST(PartSolids, ABodyInsideAMeshDoesNotMeetItsSurface)
{
    const PartSolids block(make_box_mesh({0.3, 0.3, 0.3}));
    const Geometry small{"small", Box{{0.05, 0.05, 0.05}}, {}}, plate{"plate", Box{{0.9, 0.9, 0.01}}, {}};
    const Isometry3d at = Isometry3d::Identity();
    EXPECT_FALSE(surely_meet(block, at, PlacedBody(0, small, bounds_of(small), at)));
    EXPECT_TRUE(surely_meet(block, at, PlacedBody(0, plate, bounds_of(plate), at)));
}

} // namespace
} // namespace oncollide::robot_check_test
