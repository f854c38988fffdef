#include <gtest/gtest.h>

#include "random_pose.hpp"
#include "robots/small_robot.hpp"
#include <oncollide/robots/robot.hpp>

namespace oncollide::copies_test {
namespace {

using Eigen::Isometry3d;

constexpr std::size_t copies = 300;

/// An environment of which some bodies have other poses in each copy.
class Copies : public ::testing::Test {
protected:
    struct Place {
        World world;
        std::vector<BodyId> moved;
        std::unique_ptr<Robot> robot;
    };
    /// @param poses  of the bodies that move, in the order in which they are added
    std::unique_ptr<Place> place(const Settings& settings, std::span<const Isometry3d> poses, bool padded = false) const
    {
        auto made = std::make_unique<Place>(Place{World(settings), {}, {}});
        World& world = made->world;
        std::vector<BodyId> posts = test::add_posts(world);
        Mesh wedge = make_mesh("wedge", {{0, 0, 0}, {0.3, 0, 0}, {0, 0.3, 0}, {0, 0, 0.3}},
                               {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}});
        const ModelId models[] = {world.models().add(Box{{0.02, 0.3, 0.05}}), world.models().add(Sphere{0.1}),
                                  world.models().add(std::move(wedge)), world.models().add(Cylinder{0.05, 0.3})};
        for (std::size_t k = 0; k < poses.size(); ++k)
            made->moved.push_back(world.bodies().add(
                {.model = models[k % 4], .pose = poses[k], .is_static = k % 2 == 0, .layer = k % 3 == 2 ? 2u : 1u}));
        made->robot = std::make_unique<Robot>(
            world, load_robot(files.urdf, {.srdf = files.srdf, .packages = {{"robot", files.folder().path()}}}));
        std::vector<AllowedContact> allowed{{.link = 1, .body = made->moved[1]}};
        made->robot->set_allowed(allowed);
        if (padded)
            made->robot->set_padding({.environment = 0.01, .bodies = {{made->moved[0], 0.05}, {posts[1], 0.03}}});
        return made;
    }
    std::vector<Isometry3d> random_poses(std::size_t count) const
    {
        std::vector<Isometry3d> poses;
        for (std::size_t i = 0; i < count; ++i) poses.push_back(random_pose(i, 0.9));
        return poses;
    }
    /// Compares with a World and a robot made for each copy.
    std::array<std::size_t, 4> expect_the_same(const Settings& settings, bool padded, const RobotCheck& what,
                                               std::size_t bodies = 7) const
    {
        const std::vector<Isometry3d> poses = random_poses(copies * bodies);
        const std::vector<double> numbers = test::random_numbers(copies);
        const auto shared = place(settings, std::span(poses).first(bodies), padded);
        std::vector<RobotFinding> found(copies);
        shared->robot->check(shared->world, {shared->moved, poses}, numbers, found, what);
        std::array<std::size_t, 4> counts{};
        for (std::size_t i = 0; i < copies; ++i) {
            const auto own = place(settings, std::span(poses).subspan(i * bodies, bodies), padded);
            RobotFinding truth;
            const std::size_t width = own->robot->width();
            own->robot->check(own->world, std::span(numbers).subspan(i * width, width), {&truth, 1}, what);
            EXPECT_EQ(found[i].verdict, truth.verdict) << "copy " << i;
            EXPECT_EQ(found[i].bound, truth.bound) << "copy " << i;
            EXPECT_EQ(found[i].link, truth.link) << "copy " << i;
            EXPECT_EQ(found[i].other, truth.other) << "copy " << i;
            EXPECT_EQ(found[i].body.slot, truth.body.slot) << "copy " << i;
            ++counts[static_cast<std::size_t>(found[i].verdict)];
            if (::testing::Test::HasFailure()) break;
        }
        return counts;
    }
    test::SmallRobot files;
};

TEST_F(Copies, HaveTheResultsOfWorldsOfTheirOwn)
{
    const auto counts = expect_the_same({}, false, {});
    EXPECT_GT(counts[static_cast<std::size_t>(Verdict::separate)], 30u);
    EXPECT_GT(counts[static_cast<std::size_t>(Verdict::colliding)], 30u);
}

TEST_F(Copies, HaveThemAlsoForBoundsSolidsAndPadding)
{
    expect_the_same({.max_error = 0.01, .exact = ExactLevel::off}, false, {});
    expect_the_same({.clearance = 0.02}, false, {});
    expect_the_same({.mode = Mode::solid}, false, {});
    const auto counts = expect_the_same({}, true, {});
    EXPECT_GT(counts[static_cast<std::size_t>(Verdict::within)], 3u);
}

TEST_F(Copies, RespectTheFilterAndWhatIsTested)
{
    expect_the_same({}, false, {.self = false});
    expect_the_same({}, false, {.self = false, .filter = {.mask = 1}});
    expect_the_same({}, false, {.environment = false});
    expect_the_same({}, false, {.self = false}, 90); // more bodies than the masks of neighbours hold
}

TEST_F(Copies, HaveTheSameBitsForAnyNumberOfThreads)
{
    const std::size_t bodies = 5;
    const std::vector<Isometry3d> poses = random_poses(copies * bodies);
    const std::vector<double> numbers = test::random_numbers(copies);
    std::vector<RobotFinding> one(copies), many(copies);
    for (const int threads : {1, 4}) {
        const auto shared = place({.threads = threads}, std::span(poses).first(bodies));
        shared->robot->check(shared->world, {shared->moved, poses}, numbers, threads == 1 ? one : many);
    }
    for (std::size_t i = 0; i < copies; ++i) {
        EXPECT_EQ(one[i].verdict, many[i].verdict);
        EXPECT_EQ(one[i].link, many[i].link);
        EXPECT_EQ(one[i].other, many[i].other);
        EXPECT_EQ(one[i].body.slot, many[i].body.slot);
    }
}

TEST_F(Copies, LeaveTheWorldAsItIs)
{
    const std::vector<Isometry3d> poses = random_poses(2);
    const auto shared = place({}, poses);
    const std::vector<double> numbers = test::random_numbers(1);
    std::vector<RobotFinding> before(1), found(1), after(1);
    shared->robot->check(shared->world, numbers, before);
    std::vector<Isometry3d> away(2, Isometry3d(Eigen::Translation3d(50, 0, 0)));
    shared->robot->check(shared->world, {shared->moved, away}, numbers, found);
    shared->robot->check(shared->world, numbers, after);
    EXPECT_EQ(before[0].verdict, after[0].verdict);
    EXPECT_EQ(before[0].body, after[0].body);
    EXPECT_EQ(shared->world.bodies().pose(shared->moved[0]).matrix(), poses[0].matrix());
}

TEST_F(Copies, RefuseWhatDoesNotFit)
{
    const std::vector<Isometry3d> poses = random_poses(2);
    const auto shared = place({}, poses);
    const std::vector<double> numbers = test::random_numbers(1);
    std::vector<RobotFinding> found(1);
    const auto error_of = [&](std::vector<BodyId> bodies, std::vector<Isometry3d> at) {
        try {
            shared->robot->check(shared->world, {bodies, at}, numbers, found);
        } catch (const Error& error) {
            return std::to_string(static_cast<int>(error.kind())) + " " + error.what();
        }
        return std::string("no error");
    };
    EXPECT_EQ(error_of(shared->moved, poses), "no error");
    EXPECT_EQ(error_of(shared->moved, {poses[0]}), "64 robot: check: 1 poses for 1 copies of 2 bodies");
    EXPECT_EQ(error_of({shared->moved[0], shared->moved[0]}, poses),
              "64 robot: check: a body of the copies is listed twice");
    EXPECT_EQ(error_of({shared->moved[0], BodyId{}}, poses),
              "64 robot: check: body 1 of the copies is not in the World");
    std::vector<Isometry3d> bad = poses;
    bad[1].translation().x() = std::nan("");
    EXPECT_TRUE(error_of(shared->moved, bad).starts_with("65 robot: check: copy 0: body 1: "))
        << error_of(shared->moved, bad);
    shared->robot->add_bodies(shared->world);
    EXPECT_EQ(error_of({shared->robot->bodies()[0], shared->moved[0]}, poses),
              "64 robot: check: a body of the copies is the robot's own");
}

} // namespace
} // namespace oncollide::copies_test
