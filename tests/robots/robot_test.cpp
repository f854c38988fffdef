#include <gtest/gtest.h>

#include "robots/small_robot.hpp"
#include <oncollide/robots/robot.hpp>

namespace oncollide::robot_test {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Translation3d;
using Eigen::Vector3d;
using test::add_posts, test::random_numbers, test::SmallRobot;

class RobotTest : public ::testing::Test {
protected:
    RobotTest()
        : description(load_robot(files.urdf, {.srdf = files.srdf, .packages = {{"robot", files.folder().path()}}}))
    {
    }
    /// The links' poses, written out by hand.
    static std::vector<Isometry3d> poses_by_hand(const Isometry3d& base, double turn, double elbow, double slide)
    {
        std::vector<Isometry3d> poses(6, base);
        poses[1] = base * Translation3d(0, 0, 0.1) * AngleAxisd(0.5 + turn, Vector3d::UnitZ());
        poses[2] = poses[1] * Translation3d(0, 0, 0.5) * AngleAxisd(0.05, Vector3d::UnitX()) *
                   AngleAxisd(elbow, Vector3d::UnitY());
        poses[3] = poses[2] * Translation3d(slide, 0, 0.5);
        poses[4] = poses[5] = poses[2] * Translation3d(-2 * slide + 0.01, 0, 0.5);
        return poses;
    }
    struct TwoChecks {
        std::vector<RobotFinding> found, certain;
    };
    /// The same configurations among posts, in a World with these settings and in an exact one.
    TwoChecks bounded_and_certain(const Settings& settings) const;

    SmallRobot files;
    RobotDescription description;
};

TEST_F(RobotTest, PosesAreTheProductsOfTheJoints)
{
    World world;
    const Isometry3d base(Translation3d(1, 2, 3) * AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()));
    const Robot robot(world, description, base);
    EXPECT_EQ(robot.names(), (std::vector<std::string>{"turn", "elbow", "slide"}));
    std::vector<Isometry3d> poses(6);
    const std::vector<double> numbers = random_numbers(50);
    for (std::size_t i = 0; i < numbers.size(); i += 3) {
        robot.link_poses(std::span(numbers).subspan(i, 3), poses);
        const auto expected = poses_by_hand(base, numbers[i], numbers[i + 1], numbers[i + 2]);
        for (std::size_t k = 0; k < poses.size(); ++k)
            EXPECT_LT((poses[k].matrix() - expected[k].matrix()).cwiseAbs().maxCoeff(), 1e-14);
    }
}

TEST_F(RobotTest, PlanarAndFloatingJointsMoveInTheirFrames)
{
    RobotDescription two = description;
    two.joints[0].kind = JointKind::planar, two.joints[1].kind = JointKind::floating;
    two.states.clear(); // of the joints as they were
    World world;
    const Robot robot(world, two);
    ASSERT_EQ(robot.width(), 11u);
    EXPECT_EQ(robot.names()[2], "turn/angle");
    std::vector<double> q = robot.neutral();
    q[0] = 1, q[1] = 2, q[2] = 0.4; // planar
    const Eigen::Quaterniond rotation(AngleAxisd(1.1, Vector3d(1, -1, 2).normalized()));
    q[3] = 5, q[4] = 6, q[5] = 7, q[6] = rotation.x(), q[7] = rotation.y(), q[8] = rotation.z(), q[9] = rotation.w();
    std::vector<Isometry3d> poses(6);
    robot.link_poses(q, poses);
    const Isometry3d upper = Translation3d(0, 0, 0.1) * AngleAxisd(0.5, Vector3d::UnitZ()) * Translation3d(1, 2, 0) *
                             AngleAxisd(0.4, Vector3d::UnitZ());
    EXPECT_TRUE(poses[1].isApprox(upper, 1e-13));
    EXPECT_TRUE(poses[2].isApprox(upper * Translation3d(0, 0, 0.5) * AngleAxisd(0.05, Vector3d::UnitX()) *
                                      Translation3d(5, 6, 7) * rotation,
                                  1e-13));
}

TEST_F(RobotTest, NamesJointsThatAreNotFiniteOrOutOfTheirLimits)
{
    World world;
    const Robot robot(world, description);
    const auto error_of = [&](std::vector<double> q, bool limits) -> std::string {
        try {
            robot.check_configuration(q, limits);
        } catch (const Error& error) {
            return error.what();
        }
        return "";
    };
    EXPECT_EQ(error_of({0, 0, 0.05}, true), "");
    EXPECT_EQ(error_of({0, 2.6, 0.05}, false), "");
    EXPECT_NE(error_of({0, 2.6, 0.05}, true).find("joint 'elbow': 2.6 is out of its limits, -3 to 2.5"),
              std::string::npos);
    EXPECT_NE(error_of({0, 0, std::nan("")}, false).find("joint 'slide'"), std::string::npos);
    EXPECT_NE(error_of({0, 0}, false).find("a configuration of 2 numbers"), std::string::npos);
}

TEST_F(RobotTest, StatesSetTheirJointsAlone)
{
    World world;
    const Robot robot(world, description);
    std::vector<double> q = robot.neutral();
    EXPECT_EQ(q, (std::vector<double>{0, 0, 0.03})); // the slide's lower limit
    q[0] = 9;
    robot.apply_state("bent", "", q);
    EXPECT_EQ(q, (std::vector<double>{9, 1.5, 0.03}));
    EXPECT_THROW(robot.apply_state("bend", "", q), Error);
    EXPECT_THROW(robot.apply_state("bent", "hand", q), Error);
}

/// Each configuration is also tested by frames of a World in which the robot is bodies.
TEST_F(RobotTest, BatchesFindWhatFramesFind)
{
    for (const int threads : {1, 2}) {
        World world({.threads = threads}), frames;
        add_posts(world), add_posts(frames);
        const Robot robot(world, description);
        Robot mover(frames, description);
        mover.add_bodies(frames);
        constexpr std::size_t count = 1000;
        const std::vector<double> numbers = random_numbers(count);
        std::vector<RobotFinding> found(count), self(count), outside(count);
        robot.check(world, numbers, found);
        robot.check(world, numbers, self, {.environment = false});
        robot.check(world, numbers, outside, {.self = false});
        std::size_t colliding = 0, in_self = 0;
        for (std::size_t i = 0; i < count; ++i) {
            mover.set_joints(frames, std::span(numbers).subspan(3 * i, 3));
            bool hits_self = false, hits_post = false;
            for (const PairResult& pair : frames.step().pairs)
                if (pair.verdict == Verdict::colliding)
                    (frames.bodies().is_static(pair.a) || frames.bodies().is_static(pair.b) ? hits_post : hits_self) =
                        true;
            colliding += hits_self || hits_post, in_self += hits_self;
            EXPECT_EQ(found[i].verdict == Verdict::colliding, hits_self || hits_post) << i;
            EXPECT_EQ(self[i].verdict == Verdict::colliding, hits_self) << i;
            EXPECT_EQ(outside[i].verdict == Verdict::colliding, hits_post) << i;
            if (self[i].verdict == Verdict::colliding) {
                EXPECT_NE(self[i].other, RobotFinding::no_link);
            }
            if (outside[i].verdict == Verdict::colliding) {
                EXPECT_TRUE(world.bodies().contains(outside[i].body));
            }
        }
        EXPECT_GT(in_self, 20u); // the test tests something
        EXPECT_GT(colliding, in_self + 100);
        EXPECT_LT(colliding, count - 100);
    }
}

RobotTest::TwoChecks RobotTest::bounded_and_certain(const Settings& settings) const
{
    World world(settings), exact;
    add_posts(world), add_posts(exact);
    const Robot robot(world, description), truth(exact, description);
    constexpr std::size_t count = 1000;
    const std::vector<double> numbers = random_numbers(count);
    TwoChecks checks{std::vector<RobotFinding>(count), std::vector<RobotFinding>(count)};
    robot.check(world, numbers, checks.found);
    truth.check(exact, numbers, checks.certain);
    return checks;
}

/// A bound takes longer than the exact decision.
TEST_F(RobotTest, ACheckWithinAnErrorIsExactWhereThatIsFaster)
{
    const auto [found, certain] = bounded_and_certain({.max_error = 0.02});
    for (std::size_t i = 0; i < found.size(); ++i) {
        EXPECT_EQ(found[i].verdict, certain[i].verdict) << i;
        EXPECT_EQ(found[i].link, certain[i].link) << i;
        EXPECT_EQ(found[i].other, certain[i].other) << i;
    }
}

TEST_F(RobotTest, BoundsHoldWithinAnError)
{
    const auto [found, certain] =
        bounded_and_certain({.max_error = 0.02, .exact = ExactLevel::off, .bounding_volume = BoundingVolume::sphere});
    std::size_t refused = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
        if (certain[i].verdict == Verdict::colliding) {
            EXPECT_NE(found[i].verdict, Verdict::separate) << i;
        } else {
            refused += found[i].verdict != Verdict::separate;
        }
        if (found[i].verdict == Verdict::within) {
            EXPECT_LE(found[i].bound, 0.02 + 1e-9) << i;
        }
    }
    EXPECT_GT(refused, 0u);
    EXPECT_LT(refused, 100u);
}

TEST_F(RobotTest, OwnBodiesDoNotCount)
{
    World world;
    Robot robot(world, description);
    robot.add_bodies(world);
    EXPECT_EQ(robot.bodies().size(), 5u);
    std::vector<RobotFinding> found(1);
    robot.check(world, std::vector<double>{0.01, 0.02, 0.05}, found);
    EXPECT_EQ(found[0].verdict, Verdict::separate);
    EXPECT_THROW(robot.attach(world, 3, world.models().add(Sphere{0.1}), Isometry3d::Identity()), Error);
    robot.remove_bodies(world);
    EXPECT_EQ(world.bodies().size(), 0u);
    World other;
    EXPECT_THROW(robot.check(other, std::vector<double>{0, 0, 0}, found), Error);
}

TEST_F(RobotTest, PosesThatAreNotRigidAreRefused)
{
    Isometry3d far = Isometry3d::Identity(), mirrored = far, larger = far;
    far.translation().x() = std::nan(""), mirrored.linear().col(0) *= -1, larger.linear() *= 1.01;
    for (const Isometry3d& bad : {far, mirrored, larger}) {
        World world;
        EXPECT_THROW(Robot(world, description, bad), Error);
        Robot robot(world, description);
        EXPECT_THROW(robot.set_base(bad), Error);
        EXPECT_THROW(robot.attach(world, 3, world.models().add(Sphere{0.1}), bad), Error);
        RobotDescription changed = description;
        changed.joints[1].origin = bad;
        EXPECT_THROW(Robot(world, changed), Error);
        changed = description;
        changed.links[1].collision[0].pose = bad;
        EXPECT_THROW(Robot(world, changed), Error);
        std::vector<RobotFinding> found(1);
        robot.check(world, std::vector<double>{0.01, 0.02, 0.05}, found); // nothing has changed
        EXPECT_EQ(found[0].verdict, Verdict::separate);
    }
}

TEST_F(RobotTest, AnAttachedObjectCollidesButNotWithWhatHoldsIt)
{
    World world;
    Robot robot(world, description);
    const std::vector<double> numbers = random_numbers(300);
    std::vector<RobotFinding> before(300), after(300), again(300);
    robot.check(world, numbers, before);
    const ModelId plate = world.models().add(Box{{0.35, 0.35, 0.01}});
    const std::vector<std::uint32_t> touching{2, 4}; // the lower arm, the right finger
    robot.attach(world, 3, plate, Isometry3d::Identity(), touching);
    robot.check(world, numbers, after);
    std::size_t more = 0;
    for (std::size_t i = 0; i < 300; ++i) {
        if (before[i].verdict == Verdict::colliding) {
            EXPECT_EQ(after[i].verdict, Verdict::colliding);
        }
        more += after[i].verdict != before[i].verdict;
        if (after[i].verdict != before[i].verdict) {
            EXPECT_TRUE(after[i].link <= 1 || after[i].other <= 1) << after[i].link << " " << after[i].other;
        }
    }
    EXPECT_GT(more, 5u);
    robot.detach_all();
    robot.check(world, numbers, again);
    for (std::size_t i = 0; i < 300; ++i) EXPECT_EQ(again[i].verdict, before[i].verdict);
}

} // namespace
} // namespace oncollide::robot_test
