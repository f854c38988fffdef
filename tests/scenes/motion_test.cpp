#include <cmath>

#include <gtest/gtest.h>

#include "same_scene.hpp"
#include "test_files.hpp"
#include <oncollide/base/numbers/random.hpp>
#include <oncollide/scenes/motion.hpp>

namespace oncollide {
namespace {

using Eigen::Isometry3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using test::expect_error;

Quaterniond turn(double angle, const Vector3d& axis)
{
    return Quaterniond(Eigen::AngleAxisd(angle, axis.normalized()));
}

Isometry3d pose(const Vector3d& position, const Quaterniond& rotation = Quaterniond::Identity())
{
    Isometry3d result = Isometry3d::Identity();
    result.linear() = rotation.toRotationMatrix();
    result.translation() = position;
    return result;
}

TEST(Random, SplitmixGivesThePublishedSequence)
{
    // The first outputs of Vigna's splitmix64.c for seed 1234567, whose state grows by the constant that splitmix adds.
    const std::uint64_t expected[] = {6457827717110365317u, 3203168211198807973u, 9817491932198370423u};
    std::uint64_t state = 1234567;
    for (const std::uint64_t value : expected) {
        EXPECT_EQ(splitmix(state), value);
        state += 0x9E3779B97F4A7C15u;
    }
}

TEST(Random, UnitNumbersAreInRangeAndDependOnEveryArgument)
{
    double sum = 0;
    for (std::uint64_t i = 0; i < 10000; ++i) {
        const double u = u01(1, i, 2);
        ASSERT_GE(u, 0);
        ASSERT_LT(u, 1);
        sum += u;
    }
    EXPECT_NEAR(sum / 10000, 0.5, 0.02);
    EXPECT_NE(u01(1, 2, 3), u01(2, 2, 3));
    EXPECT_NE(u01(1, 2, 3), u01(1, 3, 3));
    EXPECT_NE(u01(1, 2, 3), u01(1, 2, 4));
}

TEST(Keyed, StandsBeforeTheFirstAndAfterTheLastKey)
{
    const Motion motion = Keyed{{{10, {1, 2, 3}, turn(0.5, {0, 0, 1})}, {20, {4, 5, 6}, turn(1, {0, 0, 1})}}};
    const Isometry3d start = Isometry3d::Identity();
    for (const double time : {-5.0, 0.0, 10.0})
        EXPECT_TRUE(pose_at(motion, start, time).isApprox(pose({1, 2, 3}, turn(0.5, {0, 0, 1})), 1e-15)) << time;
    for (const double time : {20.0, 21.0, 1e9})
        EXPECT_TRUE(pose_at(motion, start, time).isApprox(pose({4, 5, 6}, turn(1, {0, 0, 1})), 1e-15)) << time;
}

TEST(Keyed, RunsEvenlyBetweenKeysInPositionAndAngle)
{
    const Vector3d axis(1, 2, -1);
    const Motion motion =
        Keyed{{{0, {0, 0, 0}, turn(0.2, axis)}, {4, {4, 8, -4}, turn(1.4, axis)}, {6, {0, 0, 0}, turn(0, axis)}}};
    for (const double time : {0.0, 0.5, 1.0, 2.25, 3.999, 4.0}) {
        const Isometry3d expected = pose(time * Vector3d(1, 2, -1), turn(0.2 + 0.3 * time, axis));
        EXPECT_TRUE(pose_at(motion, Isometry3d::Identity(), time).isApprox(expected, 1e-13)) << time;
    }
    EXPECT_TRUE(pose_at(motion, Isometry3d::Identity(), 5).isApprox(pose({2, 4, -2}, turn(0.7, axis)), 1e-13));
}

TEST(Keyed, TurnsTheShorterWayRound)
{
    const Quaterniond target = turn(0.4, {0, 0, 1});
    for (const Quaterniond& end : {target, Quaterniond(-target.coeffs())}) {
        const Motion motion = Keyed{{{0, {0, 0, 0}, Quaterniond::Identity()}, {1, {0, 0, 0}, end}}};
        EXPECT_TRUE(
            pose_at(motion, Isometry3d::Identity(), 0.5).isApprox(pose({0, 0, 0}, turn(0.2, {0, 0, 1})), 1e-14));
    }
}

TEST(Drift, BouncesLikeSmallStepsThatReflectAtTheWalls)
{
    const Drift drift{.velocity = {0.37, -0.11, 0.9}, .spin = Vector3d::Zero(), .walls = {{-1, 0, 2}, {1, 3, 2.5}}};
    Vector3d position(0.5, 1, 2.25), velocity = drift.velocity;
    const Isometry3d start = pose(position);
    for (int frame = 0; frame < 500; ++frame) {
        const Vector3d closed = pose_at(drift, start, frame).translation();
        ASSERT_LT((closed - position).norm(), 1e-9) << "frame " << frame;
        position += velocity;
        for (int axis = 0; axis < 3; ++axis)
            while (position[axis] < drift.walls.min[axis] || position[axis] > drift.walls.max[axis]) {
                const bool low = position[axis] < drift.walls.min[axis];
                position[axis] = 2 * (low ? drift.walls.min[axis] : drift.walls.max[axis]) - position[axis];
                velocity[axis] = -velocity[axis];
            }
    }
}

TEST(Drift, StaysInsideTheWallsForeverWhereverItStarts)
{
    const Aabb walls{{-1, -1, 5}, {1, 1, 5}}; // no room along z
    for (const Vector3d& from : {Vector3d(0, 0, 5), Vector3d(-7, 30, 0), Vector3d(1, -1, 9)})
        for (const double frame : {0.0, 1.0, 17.0, 1e6, 2e9}) {
            const Vector3d p =
                pose_at(Drift{{0.3, -0.7, 0.1}, Vector3d::Zero(), walls}, pose(from), frame).translation();
            EXPECT_TRUE((p.array() >= walls.min.array()).all() && (p.array() <= walls.max.array()).all())
                << from.transpose() << " at " << frame << ": " << p.transpose();
        }
}

TEST(Drift, StartsExactlyAtTheStartPose)
{
    const Isometry3d start = pose({0.1, 0.2, 0.3}, turn(1.1, {3, 1, 2}));
    const Drift drift{{0.3, 0, 0}, {0.1, 0.2, 0}, {{0, 0, 0}, {1, 1, 1}}};
    EXPECT_EQ(pose_at(drift, start, 0).matrix(), start.matrix());
}

TEST(Drift, SpinsAboutTheWorldAxisThroughItsOrigin)
{
    const Vector3d spin(0, 0.01, 0.02);
    const Quaterniond at_start = turn(0.7, {1, 0, 0});
    const Isometry3d expected = pose({100, 0, 0}, turn(100 * spin.norm(), spin) * at_start);
    EXPECT_TRUE(pose_at(Drift{{1, 0, 0}, spin, {}}, pose({0, 0, 0}, at_start), 100).isApprox(expected, 1e-13));
}

TEST(Drift, StaysRigidOverAMillionFrames)
{
    const Drift drift{Vector3d::Zero(), {0.03, -0.04, 0.01}, {}};
    const Eigen::Matrix3d r = pose_at(drift, pose({0, 0, 0}, turn(0.7, {1, 5, 2})), 1e6).linear();
    EXPECT_TRUE((r.transpose() * r).isIdentity(1e-14));
}

TEST(Jitter, StepsAndReflectsAsTheBenchmarkSays)
{
    const Jitter jitter{.step = 0.2, .seed = 13345, .index = 7, .walls = {{0, 0, 0}, {1, 1, 1}}};
    Vector3d p(0.01, 0.99, 0.5), expected = p;
    bool reflected = false;
    for (std::uint64_t f = 1; f <= 200; ++f) {
        jitter_step(jitter, f, p);
        for (std::uint64_t axis = 0; axis < 3; ++axis) {
            double& e = expected[Eigen::Index(axis)];
            e += 0.2 * (u01(12345 + 1000 + f, 7, axis) - 0.5);
            reflected |= e < 0 || e > 1;
            if (e < 0) e = -e;
            if (e > 1) e = 2 - e;
        }
        ASSERT_TRUE(test::same_bits(p, expected)) << f;
    }
    EXPECT_TRUE(reflected) << "the motion must reach a wall";
}

TEST(Jitter, KeepsABodyInARoomSmallerThanItsStep)
{
    const Jitter jitter{.step = 10, .seed = 1, .index = 0, .walls = {{0, 0, 0}, {1, 1, 1}}};
    Vector3d p(0.5, 0.5, 0.5);
    for (std::uint64_t f = 1; f <= 100; ++f) {
        jitter_step(jitter, f, p);
        ASSERT_TRUE((p.array() >= 0).all() && (p.array() <= 1).all()) << f;
    }
}

TEST(CheckMotion, RefusesWhatHasNoMeaning)
{
    const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
    const Quaterniond one = Quaterniond::Identity();
    const Vector3d zero = Vector3d::Zero();
    const auto refuses = [](const Motion& motion, const char* word) {
        expect_error(
            ErrorKind::bad_data, [&] { check_motion("ball", motion); }, "ball: ", word);
    };
    refuses(Keyed{}, "no key");
    refuses(Keyed{{{0, {0, 0, 0}, one}, {0, {1, 0, 0}, one}}}, "key 1: time");
    refuses(Keyed{{{1, {0, 0, 0}, one}, {0, {1, 0, 0}, one}}}, "key 1: time");
    refuses(Keyed{{{nan, {0, 0, 0}, one}}}, "key 0: time");
    refuses(Keyed{{{0, {0, inf, 0}, one}}}, "key 0: position");
    refuses(Keyed{{{0, {0, 0, 0}, Quaterniond(0, 0, 0, 0)}}}, "quaternion");
    refuses(Keyed{{{0, {0, 0, 0}, Quaterniond(nan, 0, 0, 0)}}}, "quaternion");
    refuses(Drift{{nan, 0, 0}, zero, {}}, "velocity");
    refuses(Drift{zero, {0, 1e16, 0}, {}}, "spin");
    refuses(Drift{zero, zero, {{0, 0, 0}, {1, 1, inf}}}, "walls");
    refuses(Jitter{.step = -1, .walls = {}}, "step");
    refuses(Jitter{.step = nan, .walls = {}}, "step");
    EXPECT_NO_THROW(check_motion("ball", Still{}));
    EXPECT_NO_THROW(check_motion("ball", Drift{}));
    EXPECT_NO_THROW(check_motion("ball", Jitter{}));
}

TEST(LoadTum, TurnsSecondsIntoFramesFromTheFirstLine)
{
    const test::TemporaryFolder folder;
    const auto path = folder.write("path.tum", "# a comment\r\n\n"
                                               "100.5 1 2 3 0 0 0 1\r\n"
                                               "  101 4 5 6 0 0 0.6 0.8   \n"
                                               "103.5 +7 8e0 -9 1 0 0 0");
    std::vector<std::string> warnings;
    const Keyed motion = load_tum(path, 30, warnings);
    ASSERT_EQ(motion.keys.size(), 3u);
    EXPECT_EQ(motion.keys[0].time, 0);
    EXPECT_EQ(motion.keys[1].time, 15);
    EXPECT_EQ(motion.keys[2].time, 90);
    EXPECT_EQ(motion.keys[1].position, Vector3d(4, 5, 6));
    EXPECT_EQ(motion.keys[1].rotation.coeffs(), Eigen::Vector4d(0, 0, 0.6, 0.8));
    EXPECT_EQ(motion.keys[2].position, Vector3d(7, 8, -9));
    EXPECT_TRUE(warnings.empty());
}

TEST(LoadTum, NormalisesQuaternionsAndSaysSo)
{
    const test::TemporaryFolder folder;
    const auto path = folder.write("path.tum", "0 0 0 0 0 0 0 2\n1 0 0 0 0 0 0 1.00000001\n");
    std::vector<std::string> warnings;
    const Keyed motion = load_tum(path, 1, warnings);
    EXPECT_EQ(motion.keys[0].rotation.w(), 1);
    EXPECT_EQ(motion.keys[1].rotation.w(), 1);
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_NE(warnings[0].find("path.tum:1: quaternion of length 2"), std::string::npos) << warnings[0];
}

TEST(LoadTum, NamesTheLineOfEveryFault)
{
    const test::TemporaryFolder folder;
    std::vector<std::string> warnings;
    const auto refuses = [&](const char* content, const char* where, const char* what) {
        const auto path = folder.write("bad.tum", content);
        expect_error(
            ErrorKind::bad_data, [&] { load_tum(path, 30, warnings); }, where, what);
    };
    refuses("0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0\n", "bad.tum:2: ", "7 numbers");
    refuses("0 0 0 0 0 0 0 1 5\n", "bad.tum:1: ", "more than eight");
    refuses("0 0 0 zero 0 0 0 1\n", "bad.tum:1: ", "'zero'");
    refuses("0 0 0 1.5x 0 0 0 1\n", "bad.tum:1: ", "'1.5x'");
    refuses("0 nan 0 0 0 0 0 1\n", "bad.tum:1: ", "'nan'");
    refuses("0 1e999 0 0 0 0 0 1\n", "bad.tum:1: ", "'1e999'");
    refuses("0 0 0 0 0 0 0 1\n0 0 0 0 0 0 0 1\n", "bad.tum:2: ", "time 0");
    refuses("0 0 0 0 0 0 0 0\n", "bad.tum:1: ", "length 0");
    refuses("# only a comment\n", "bad.tum: ", "no pose");
    refuses("", "bad.tum: ", "empty");
    expect_error(
        ErrorKind::no_input, [&] { load_tum(folder.path() / "none.tum", 30, warnings); }, "none.tum: ");
    expect_error(
        ErrorKind::no_input, [&] { load_tum(folder.path(), 30, warnings); }, "folder");
    const auto good = folder.write("good.tum", "0 0 0 0 0 0 0 1\n");
    for (const double rate : {0.0, -1.0, std::nan("")})
        expect_error(
            ErrorKind::usage, [&] { load_tum(good, rate, warnings); }, "frames per second");
}

} // namespace
} // namespace oncollide
