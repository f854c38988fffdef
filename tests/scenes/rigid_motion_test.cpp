#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "random_pose.hpp"
#include "test_files.hpp"
#include <oncollide/scenes/scene.hpp>

namespace oncollide {
namespace {

using Eigen::AngleAxisd, Eigen::Isometry3d, Eigen::Vector3d;
using test::expect_error;

Isometry3d placed(const Vector3d& position, double angle = 0, const Vector3d& axis = Vector3d::UnitZ())
{
    Isometry3d pose(AngleAxisd(angle, axis.normalized()));
    pose.translation() = position;
    return pose;
}

TEST(RigidMotion, EndsExactlyAtItsPoses)
{
    for (std::uint64_t seed = 0; seed < 50; ++seed) {
        const Isometry3d from = random_pose(2 * seed, 3), to = random_pose(2 * seed + 1, 3);
        for (const MotionPath path : {MotionPath::linear, MotionPath::screw}) {
            const RigidMotion motion(from, to, path);
            EXPECT_EQ(motion.pose(0).matrix(), from.matrix());
            EXPECT_EQ(motion.pose(1).matrix(), to.matrix());
            EXPECT_LT((motion.pose(0x1p-40).matrix() - from.matrix()).norm(), 1e-10);
            EXPECT_LT((motion.pose(1 - 0x1p-40).matrix() - to.matrix()).norm(), 1e-10);
        }
    }
}

TEST(RigidMotion, LinearMovesTheOriginStraightAndRotatesAlongTheShorterArc)
{
    const RigidMotion motion(placed({1, 2, 3}, 0.25), placed({5, 0, 3}, 0.25 + 3));
    const Isometry3d quarter = motion.pose(0.25);
    EXPECT_LT((quarter.translation() - Vector3d(2, 1.5, 3)).norm(), 1e-15);
    EXPECT_LT((quarter.linear() - placed({0, 0, 0}, 1).linear()).norm(), 1e-15);
    const RigidMotion back(placed({0, 0, 0}), placed({0, 0, 0}, 4)); // shorter the other way round
    EXPECT_LT((back.pose(0.5).linear() - placed({0, 0, 0}, (4 - 2 * M_PI) / 2).linear()).norm(), 1e-15);
}

TEST(RigidMotion, AHalfTurnIsAboutTheAxisWhoseLargestComponentIsPositive)
{
    for (const Vector3d& axis : {Vector3d(0, 0, 1), Vector3d(1, -3, 2), Vector3d(-0.1, 0.2, -0.05)})
        for (const double sign : {-1.0, 1.0}) {
            Eigen::Index largest;
            axis.cwiseAbs().maxCoeff(&largest);
            const double up = axis[largest] > 0 ? 1 : -1;
            const RigidMotion motion(placed({0, 0, 0}), placed({0, 0, 0}, M_PI, sign * axis));
            EXPECT_LT((motion.pose(0.5).linear() - placed({0, 0, 0}, M_PI / 2, up * axis).linear()).norm(), 1e-12);
        }
}

TEST(RigidMotion, AScrewRepeatsOneStep)
{
    for (std::uint64_t seed = 0; seed < 50; ++seed) {
        const RigidMotion motion(random_pose(2 * seed, 3), random_pose(2 * seed + 1, 3), MotionPath::screw);
        const auto step = [&](double from, double to) { return motion.pose(to) * motion.pose(from).inverse(); };
        EXPECT_LT((step(0, 0.25).matrix() - step(0.5, 0.75).matrix()).norm(), 1e-12) << seed;
        EXPECT_LT((step(0, 0.25).matrix() - step(0.75, 1).matrix()).norm(), 1e-12) << seed;
    }
    const Isometry3d from = random_pose(7, 3), to(Eigen::Translation3d(1, 2, 3) * from);
    EXPECT_LT(
        (RigidMotion(from, to, MotionPath::screw).pose(0.5).translation() - from.translation() - Vector3d(0.5, 1, 1.5))
            .norm(),
        1e-14)
        << "without rotation";
}

TEST(RigidMotion, NoPointTravelsFartherThanTheBound)
{
    double tightest = std::numeric_limits<double>::infinity();
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        const MotionPath path = seed % 2 ? MotionPath::screw : MotionPath::linear;
        const RigidMotion::Key keys[] = {
            {0, random_pose(3 * seed, 2)}, {0.4, random_pose(3 * seed + 1, 2)}, {1, random_pose(3 * seed + 2, 2)}};
        const RigidMotion motion(keys, path);
        const Vector3d centre = random_pose(seed, 1).translation();
        const double begin = u01(seed, 5, 0), end = begin + (1 - begin) * u01(seed, 5, 1);
        const double most = motion.travel(begin, end, centre, 0.5);
        double moved = 0;
        for (std::uint64_t k = 0; k < 50; ++k) {
            const Vector3d point = centre + 0.5 * random_pose(1000 + k, 1).translation().normalized();
            const double time = k == 0 ? end : begin + (end - begin) * u01(seed, 6, k);
            moved = std::max(moved, (motion.pose(time) * point - motion.pose(begin) * point).norm());
        }
        EXPECT_LE(moved, most) << seed;
        tightest = std::min(tightest, most / moved);
    }
    EXPECT_LT(tightest, 1.1) << "the bound is close for some";
}

TEST(RigidMotion, TheStateIsTheMotionUntilTheNextKey)
{
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        const RigidMotion::Key keys[] = {
            {0, random_pose(3 * seed, 2)}, {0.5, random_pose(3 * seed + 1, 2)}, {1, random_pose(3 * seed + 2, 2)}};
        const RigidMotion motion(keys, seed % 2 ? MotionPath::screw : MotionPath::linear);
        const RigidMotion::State state = motion.at(0.6);
        EXPECT_EQ(state.key, 1);
        EXPECT_EQ(motion.at(0.2).key, 0.5);
        const Vector3d point(0.3, -0.2, 0.1), at = state.pose * point;
        const double dt = 0.3, angle = dt * state.angular.norm();
        const Vector3d there =
            state.pivot + dt * state.velocity + AngleAxisd(angle, state.angular.normalized()) * (at - state.pivot);
        EXPECT_LT((there - motion.pose(0.9) * point).norm(), 1e-12);
    }
}

TEST(RigidMotion, RefusesBadInputWithOneClearError)
{
    const Isometry3d here = Isometry3d::Identity();
    Isometry3d bad = here;
    bad.translation().x() = std::numeric_limits<double>::quiet_NaN();
    expect_error(
        ErrorKind::bad_data, [&] { RigidMotion(here, bad); }, "motion: last pose: the pose is not finite");
    Isometry3d stretched = here;
    stretched.linear() *= 1.1;
    expect_error(
        ErrorKind::bad_data, [&] { RigidMotion(stretched, here); }, "motion: first pose: the pose is not rigid");
    const auto keyed = [&](std::initializer_list<double> times) {
        std::vector<RigidMotion::Key> keys;
        for (const double time : times) keys.push_back({time, here});
        RigidMotion motion{std::span<const RigidMotion::Key>(keys)};
    };
    expect_error(
        ErrorKind::bad_data, [&] { keyed({0}); }, "give at least two");
    expect_error(
        ErrorKind::bad_data,
        [&] {
            keyed({0, 0.5, 0.4, 1});
        },
        "key 2: time 0.4 does not come after");
    expect_error(
        ErrorKind::bad_data,
        [&] {
            keyed({0, 0, 1});
        },
        "key 1: time 0 does not come after");
    expect_error(
        ErrorKind::bad_data,
        [&] {
            keyed({0, 2});
        },
        "must run from 0 to 1");
    expect_error(
        ErrorKind::bad_data,
        [&] {
            keyed({0, std::nan(""), 1});
        },
        "key 1: the time is not finite");
}

/// The keys are uneven in time, and some are half a turn apart.
Keyed many_keys()
{
    Keyed motion;
    double time = 0;
    for (std::uint64_t i = 0; i < 30; ++i) {
        const Isometry3d pose = random_pose(i, 5);
        Eigen::Quaterniond rotation(pose.linear());
        const Eigen::Quaterniond half_turn(AngleAxisd(i % 2 ? M_PI : -M_PI, Vector3d(1, 2, 3).normalized()));
        if (i % 3 == 1) rotation = half_turn * motion.keys.back().rotation;
        motion.keys.push_back({time += 0.1 + double(i % 4), pose.translation(), rotation.normalized()});
    }
    return motion;
}

TEST(WayBetween, PassesThePosesOfAKeyedMotion)
{
    const Keyed motion = many_keys();
    const Isometry3d start = Isometry3d::Identity();
    const double last = motion.keys.back().time + 2;
    for (const double step : {0.05, 0.7, 2.0, 9.0, last})
        for (double from = 0; from < last; from += step) {
            const double to = from + step;
            const auto pose = [&](double time) { return pose_at(motion, start, time); };
            const std::vector<RigidMotion::Key> way = way_between(motion, from, to, pose(from), pose(to));
            if (way.empty()) {
                EXPECT_EQ(pose(from + 0.5 * step).matrix(), pose(from).matrix());
                continue;
            }
            const RigidMotion whole(way);
            for (int k = 0; k <= 50; ++k) {
                const double time = k / 50.0;
                EXPECT_LT((whole.pose(time).matrix() - pose(from + time * step).matrix()).norm(), 1e-9)
                    << from << " to " << to << ", " << time;
            }
        }
}

TEST(WayBetween, IsStraightWithoutKeysAndEmptyAtRest)
{
    const Isometry3d from = placed({0, 0, 0}), to = placed({1, 0, 0});
    EXPECT_EQ(way_between(Drift{}, 0, 1, from, to).size(), 2u);
    EXPECT_TRUE(way_between(Still{}, 0, 1, from, from).empty());
    const Keyed there_and_back{{{0, {0, 0, 0}, Eigen::Quaterniond::Identity()},
                                {0.5, {1, 0, 0}, Eigen::Quaterniond::Identity()},
                                {1, {0, 0, 0}, Eigen::Quaterniond::Identity()}}};
    EXPECT_EQ(way_between(there_and_back, 0, 1, from, from).size(), 3u);
    EXPECT_EQ(way_between(there_and_back, 1, 0, from, to).size(), 2u) << "back to an earlier frame";
    EXPECT_TRUE(way_between(there_and_back, 1, 9, from, from).empty());
}

/// Their shares of the frame round to equal numbers.
TEST(WayBetween, KeepsKeysThatRoundingMakesSimultaneous)
{
    const double time = 1e15;
    Keyed jump;
    for (int i = 0; i < 5; ++i)
        jump.keys.push_back({time + 0.125 * i, {double(i % 2), 0, 0}, Eigen::Quaterniond::Identity()});
    const Isometry3d here = placed({0, 0, 0});
    const std::vector<RigidMotion::Key> way = way_between(jump, 0, 2 * time, here, here);
    ASSERT_EQ(way.size(), 7u);
    EXPECT_EQ(RigidMotion(way).pose(way[2].time).translation().x(), 1);
    const std::vector<RigidMotion::Key> late = way_between(jump, -1e15, time + 1, here, here);
    ASSERT_EQ(late.size(), 7u);
    EXPECT_EQ(RigidMotion(late).pose(late[4].time).translation().x(), 1);
}

} // namespace
} // namespace oncollide
