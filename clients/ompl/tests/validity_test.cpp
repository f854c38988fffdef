// States and motions of robots as OMPL's planners check them.
#include <oncollide/ompl/validity.hpp>

#include <cmath>
#include <numbers>
#include <random>
#include <thread>

#include <gtest/gtest.h>
#include <ompl/base/DiscreteMotionValidator.h>
#include <ompl/base/ScopedState.h>
#include <ompl/base/spaces/DubinsStateSpace.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/base/spaces/SO2StateSpace.h>
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Exception.h>

namespace ompl::base {
namespace {

using Eigen::Translation3d, Eigen::Vector3d;
using oncollide::BodySpec, oncollide::Box, oncollide::JointKind, oncollide::RobotDescription, oncollide::World;

/// An arm of two bars in a plane. Each bar is 1 m long and begins at its joint.
RobotDescription arm(JointKind shoulder = JointKind::revolute)
{
    RobotDescription robot;
    robot.name = "arm";
    const auto bar =
        std::make_shared<const oncollide::Geometry>(oncollide::Geometry{"bar", Box{{0.45, 0.02, 0.02}}, {}});
    const Eigen::Isometry3d half(Translation3d(0.5, 0, 0));
    robot.links = {{"base", {}}, {"upper", {{bar, half}}}, {"lower", {{bar, half}}}};
    robot.joints.resize(2);
    robot.joints[0] = {.name = "shoulder", .kind = shoulder, .parent = 0, .child = 1, .axis = Vector3d::UnitZ()};
    robot.joints[1] = {
        .name = "elbow", .kind = JointKind::revolute, .parent = 1, .child = 2, .axis = Vector3d::UnitZ()};
    robot.joints[1].origin.translation().x() = 1;
    for (auto& joint : robot.joints)
        if (joint.kind == JointKind::revolute) joint.lower = -3, joint.upper = 3;
    robot.excluded = {{1, 2}};
    robot.groups = {{"whole", {0, 1, 2}, {0, 1}}, {"nothing", {0}, {}}};
    return robot;
}

/// The arm, a wire that crosses its plane, and OMPL's view of them.
struct Place {
    World world;
    oncollide::Robot robot;
    OncollideJoints joints;
    SpaceInformationPtr information;

    explicit Place(const RobotDescription& description = arm(), const oncollide::Settings& settings = {})
        : world(settings), robot(world, description), joints(OncollideJoints::ofGroup(world, robot, "whole")),
          information(std::make_shared<SpaceInformation>(joints.makeStateSpace()))
    {
        setOncollideValidity(information, joints);
        information->setup();
    }
    /// At a distance from the shoulder and an angle.
    void add_wire(double distance, double angle, double radius = 1e-4)
    {
        const Translation3d at(distance * std::cos(angle), distance * std::sin(angle), 0);
        world.bodies().add({.model = world.models().add(oncollide::Cylinder{radius, 2}),
                            .pose = Eigen::Isometry3d(at),
                            .is_static = true});
    }
    ScopedState<> state(double shoulder, double elbow) const
    {
        ScopedState<> state(information);
        state = std::vector<double>{shoulder, elbow};
        return state;
    }
    bool moves(const ScopedState<>& from, const ScopedState<>& to) const
    {
        return information->checkMotion(from.get(), to.get());
    }
};

TEST(OmplValidity, AStateIsValidIfTheRobotIsSeparate)
{
    Place place;
    place.add_wire(1.5, 0.7);
    EXPECT_TRUE(place.information->isValid(place.state(0, 0).get()));
    EXPECT_FALSE(place.information->isValid(place.state(0.7, 0).get()));
    EXPECT_FALSE(place.information->isValid(place.state(0.7 - 0.01, 0).get()));
    EXPECT_TRUE(place.information->isValid(place.state(0.7, 0.3).get()));
}

TEST(OmplValidity, WithinTheClearanceIsNotValid)
{
    Place exact, wide(arm(), {.clearance = 0.03});
    for (Place* place : {&exact, &wide}) place->add_wire(1.5, 0.7);
    const double beside = 0.7 - 0.04 / 1.5; // 2 cm from the bar
    EXPECT_TRUE(exact.information->isValid(exact.state(beside, 0).get()));
    EXPECT_FALSE(wide.information->isValid(wide.state(beside, 0).get()));
}

// Both forms of checkMotion() agree, also where states on the way are within the error or the clearance.
TEST(OmplValidity, ASettingOfAccuracyDecidesMotionsAlike)
{
    for (const oncollide::Settings& settings :
         {oncollide::Settings{}, oncollide::Settings{.max_error = 0.05}, oncollide::Settings{.clearance = 0.05}}) {
        Place place(arm(), settings);
        place.add_wire(1.5, 0.7), place.add_wire(1.96, -0.5);
        std::mt19937 random(4);
        std::uniform_real_distribution<double> any(-2.9, 2.9);
        int valid = 0, differ = 0;
        for (int i = 0; i < 400; ++i) {
            const ScopedState<> from = place.state(any(random), any(random)),
                                to = place.state(any(random), any(random));
            if (!place.information->isValid(from.get())) continue;
            std::pair<State*, double> last(nullptr, 0);
            const bool whole = place.moves(from, to);
            differ += whole != place.information->checkMotion(from.get(), to.get(), last);
            valid += whole;
        }
        EXPECT_GT(valid, 50);
        EXPECT_EQ(differ, 0) << settings.clearance << settings.max_error.value_or(0);
    }
}

// The wire is thinner than the way between two samples; the motion passes it from one side to the other.
TEST(OmplValidity, AThinObstacleThatOmplsDefaultResolutionMissesIsFound)
{
    Place place;
    const ScopedState<> from = place.state(0, 0), to = place.state(0.39, 0);
    const auto discrete = std::make_shared<DiscreteMotionValidator>(place.information);
    const unsigned parts = place.information->getStateSpace()->validSegmentCount(from.get(), to.get());
    ASSERT_GE(parts, 3u);
    place.add_wire(1.94, 1.5 * 0.39 / parts); // between two samples
    ASSERT_TRUE(discrete->checkMotion(from.get(), to.get())) << "sampling finds the wire; the test is void";
    EXPECT_FALSE(place.moves(from, to));
    std::pair<State*, double> last(nullptr, 2);
    EXPECT_FALSE(place.information->getMotionValidator()->checkMotion(from.get(), to.get(), last));
    const double contact = (1.5 * 0.39 / parts - std::asin(0.0201 / 1.94)) / 0.39; // the bar's side meets the wire
    EXPECT_LE(last.second, contact + 1e-9);
    EXPECT_GT(last.second, contact - 1e-3);
}

TEST(OmplValidity, LastValidIsAValidStateJustBeforeTheContact)
{
    Place place;
    place.add_wire(1.5, 0.7);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> any(-2.9, 2.9);
    int refused = 0, too_close = 0; // the bar passes the wire, or touches it soon, closer than the tolerance resolves
    for (int i = 0; i < 300; ++i) {
        const ScopedState<> from = place.state(any(random), any(random)), to = place.state(any(random), any(random));
        if (!place.information->isValid(from.get())) continue;
        ScopedState<> last(place.information);
        std::pair<State*, double> found(last.get(), -1);
        const bool valid = place.information->checkMotion(from.get(), to.get(), found);
        EXPECT_EQ(valid, place.moves(from, to));
        if (valid) {
            EXPECT_EQ(found.second, -1);
            continue;
        }
        ++refused;
        ASSERT_TRUE(found.second >= 0 && found.second < 1);
        EXPECT_TRUE(place.information->isValid(last.get()));
        ScopedState<> there(place.information);
        const auto valid_at = [&](double time) {
            place.information->getStateSpace()->interpolate(from.get(), to.get(), time, there.get());
            return place.information->isValid(there.get());
        };
        EXPECT_TRUE(valid_at(found.second));
        EXPECT_TRUE(place.information->equalStates(there.get(), last.get()));
        for (int k = 0; k < 200; ++k) EXPECT_TRUE(valid_at(found.second * k / 200));
        bool contact = false;
        for (int k = 1; k <= 3000 && !contact; ++k) contact = !valid_at(std::min(found.second + k * 1e-7, 1.0));
        too_close += !contact;
    }
    EXPECT_GT(refused, 30);
    EXPECT_LE(too_close, 2);
}

// A block slides against a wall and touches it at a share of the motion that has no rounding.
TEST(OmplValidity, LastValidIsNotTheFirstTouch)
{
    RobotDescription block;
    block.name = "block";
    const Box cube{{0.25, 0.25, 0.25}};
    block.links = {{"rail", {}},
                   {"block", {{std::make_shared<const oncollide::Geometry>(oncollide::Geometry{"", cube, {}})}}}};
    block.joints = {{.name = "slide", .kind = JointKind::prismatic, .child = 1, .lower = -4, .upper = 4}};
    block.groups = {{"whole", {0, 1}, {0}}};
    Place place(block);
    place.world.bodies().add({.model = place.world.models().add(cube),
                              .pose = Eigen::Isometry3d(Translation3d(1, 0, 0)),
                              .is_static = true});
    ScopedState<> from(place.information), to(place.information), last(place.information);
    for (const double length : {1.0, 2.0, 4.0})
        for (const double start : {0.0, 0.25, -0.5}) {
            from = std::vector<double>{start}, to = std::vector<double>{std::min(start + length, 4.0)};
            std::pair<State*, double> found(last.get(), -1);
            EXPECT_FALSE(place.information->checkMotion(from.get(), to.get(), found));
            EXPECT_TRUE(place.information->isValid(last.get())) << start << " " << length;
            EXPECT_GT(last[0], 0.5 - 0.01);
        }
}

TEST(OmplValidity, LastValidMayBeTheStartOrTheEndOrAbsent)
{
    Place place;
    place.add_wire(1.5, 0.7);
    const MotionValidator& validator = *place.information->getMotionValidator();
    ScopedState<> from = place.state(0, 0), to = place.state(1, 0), last(place.information);
    std::pair<State*, double> apart(last.get(), 0), none(nullptr, 0), start(from.get(), 0), end(to.get(), 0);
    EXPECT_FALSE(validator.checkMotion(from.get(), to.get(), apart));
    EXPECT_FALSE(validator.checkMotion(from.get(), to.get(), none));
    EXPECT_FALSE(validator.checkMotion(from.get(), to.get(), end));
    EXPECT_EQ(last, to);
    to = place.state(1, 0);
    EXPECT_FALSE(validator.checkMotion(from.get(), to.get(), start));
    EXPECT_EQ(last, from);
    EXPECT_TRUE(none.second == apart.second && start.second == apart.second && end.second == apart.second);
    // A start in contact, which OMPL rules out: it is returned itself, at time 0.
    from = place.state(0.7, 0);
    EXPECT_FALSE(validator.checkMotion(from.get(), to.get(), apart));
    EXPECT_EQ(apart.second, 0);
    EXPECT_EQ(last, from);
}

TEST(OmplValidity, MotionsAreCountedAsOmplCountsThem)
{
    Place place;
    place.add_wire(1.5, 0.7);
    const MotionValidator& validator = *place.information->getMotionValidator();
    std::pair<State*, double> last(nullptr, 0);
    const ScopedState<> a = place.state(0, 0), b = place.state(0.5, 0), c = place.state(1, 0);
    validator.checkMotion(a.get(), b.get()), validator.checkMotion(a.get(), c.get());
    validator.checkMotion(a.get(), b.get(), last), validator.checkMotion(b.get(), c.get(), last);
    validator.checkMotion(b.get(), a.get());
    EXPECT_EQ(validator.getValidMotionCount(), 3u);
    EXPECT_EQ(validator.getInvalidMotionCount(), 2u);
}

TEST(OmplValidity, ContinuousJointsTakeTheShorterWay)
{
    Place place(arm(JointKind::continuous));
    EXPECT_TRUE(place.information->getStateSpace()->isCompound());
    place.add_wire(1.5, 3.1); // on the shorter way only
    const ScopedState<> left = place.state(3, 0), right = place.state(-3, 0);
    EXPECT_FALSE(place.moves(left, right));
    EXPECT_FALSE(place.moves(right, left));
    ScopedState<> last(place.information);
    std::pair<State*, double> found(last.get(), 0);
    EXPECT_FALSE(place.information->checkMotion(left.get(), right.get(), found));
    EXPECT_NEAR(found.second, (0.1 - 0.0201 / 1.5) / (2 * std::numbers::pi - 6), 1e-3);
    EXPECT_TRUE(place.information->isValid(last.get()));

    Place other(arm(JointKind::continuous));
    other.add_wire(1.5, 0); // on the longer way only
    EXPECT_TRUE(other.moves(left, right));
    EXPECT_TRUE(other.moves(right, left));
}

TEST(OmplValidity, OtherJointsRestWhereTheyAreTold)
{
    Place place;
    place.add_wire(1.5, 0.7);
    for (const double elbow : {0.0, 0.3}) {
        const OncollideJoints shoulder(place.world, place.robot, {"shoulder"}, {0, elbow});
        const auto information = std::make_shared<SpaceInformation>(shoulder.makeStateSpace());
        setOncollideValidity(information, shoulder);
        information->setup();
        ScopedState<> state(information);
        state = std::vector<double>{0.7};
        EXPECT_EQ(information->isValid(state.get()), elbow > 0);
    }
}

TEST(OmplValidity, JointsMayBeInAnotherOrder)
{
    Place place;
    place.add_wire(1.5, 0.7);
    const OncollideJoints joints(place.world, place.robot, {"elbow", "shoulder"});
    const auto information = std::make_shared<SpaceInformation>(joints.makeStateSpace());
    setOncollideValidity(information, joints);
    information->setup();
    ScopedState<> state(information);
    state = std::vector<double>{0, 0.7};
    EXPECT_FALSE(information->isValid(state.get()));
    state = std::vector<double>{0.7, 0};
    EXPECT_TRUE(information->isValid(state.get()));
}

TEST(OmplValidity, ManyThreadsAtOnceGiveTheSameAnswers)
{
    Place place;
    place.add_wire(1.5, 0.7), place.add_wire(0.8, -1.2);
    constexpr int count = 400, threads = 4;
    std::mt19937 random(9);
    std::uniform_real_distribution<double> any(-2.9, 2.9);
    std::vector<ScopedState<>> states;
    for (int i = 0; i <= count; ++i) states.push_back(place.state(any(random), any(random)));
    std::vector<std::array<int, count>> answers(threads + 1);
    const auto ask = [&](int thread) {
        for (int i = 0; i < count; ++i) {
            std::pair<State*, double> last(nullptr, 1);
            const bool valid = place.information->checkMotion(states[i].get(), states[i + 1].get(), last);
            answers[thread][i] = 2 * int(1e6 * last.second) + valid;
            answers[thread][i] += place.information->isValid(states[i].get()) << 30;
        }
    };
    ask(0);
    std::vector<std::thread> running;
    for (int thread = 1; thread <= threads; ++thread) running.emplace_back(ask, thread);
    for (std::thread& one : running) one.join();
    for (int thread = 1; thread <= threads; ++thread) EXPECT_EQ(answers[thread], answers[0]);
    EXPECT_EQ(place.information->getMotionValidator()->getCheckedMotionCount(), unsigned((threads + 1) * count));
}

/// The message of the exception of a call.
template <class Call>
std::string refusal(Call call)
{
    try {
        call();
    } catch (const std::exception& error) {
        return error.what();
    }
    return "none";
}

TEST(OmplValidity, WrongSpacesAndNamesAreRefused)
{
    Place place;
    const auto checker_of = [&](const StateSpacePtr& space) {
        return refusal([&] { OncollideStateValidityChecker(std::make_shared<SpaceInformation>(space), place.joints); });
    };
    EXPECT_NE(
        checker_of(std::make_shared<RealVectorStateSpace>(3)).find("have 3 values, but 2 numbers of the robot move"),
        std::string::npos);
    const std::vector<std::string> names = {"shoulder", "elbow"};
    RobotDescription planar = arm();
    planar.joints[0].kind = JointKind::planar;
    World world;
    const oncollide::Robot base(world, planar);
    const OncollideJoints pose(world, base, {"shoulder/x", "shoulder/y", "shoulder/angle"});
    const auto dubins = std::make_shared<SpaceInformation>(std::make_shared<DubinsStateSpace>());
    EXPECT_NE(refusal([&] { OncollideStateValidityChecker(dubins, pose); }).find("does not interpolate"),
              std::string::npos);
    const auto plane = std::make_shared<SpaceInformation>(std::make_shared<SE2StateSpace>());
    EXPECT_EQ(refusal([&] { OncollideStateValidityChecker(plane, pose); }), "none");
    EXPECT_NE(refusal([&] { pose.makeStateSpace(); }).find("joint 'shoulder' has no limits"), std::string::npos);
    RobotDescription endless = arm();
    endless.joints[1].upper = std::numeric_limits<double>::infinity();
    const oncollide::Robot other(world, endless);
    EXPECT_NE(
        refusal([&] { OncollideJoints(world, other, names).makeStateSpace(); }).find("joint 'elbow' has no limits"),
        std::string::npos);
    const auto joints_of = [&](const std::vector<std::string>& which, std::vector<double> rest = {}) {
        return refusal([&] { OncollideJoints(place.world, place.robot, which, rest); });
    };
    const auto group = [&](const std::string& name) {
        return refusal([&] { OncollideJoints::ofGroup(place.world, place.robot, name); });
    };
    EXPECT_NE(joints_of({"elbow joint"}).find("have no 'elbow joint'; they have: shoulder, elbow"), std::string::npos);
    EXPECT_NE(joints_of({"elbow", "elbow"}).find("listed twice"), std::string::npos);
    EXPECT_NE(group("arm").find("has no group 'arm'; it has: whole, nothing"), std::string::npos);
    EXPECT_NE(group("nothing").find("no joint of the robot moves"), std::string::npos);
    EXPECT_NE(joints_of(names, {0}), "none");
    EXPECT_NE(refusal([&] { OncollideJoints(world, place.robot, names); }), "none"); // another World
    for (const double tolerance : {0.0, 2.0, std::nan("")})
        EXPECT_NE(refusal([&] {
                      OncollideMotionValidator(place.information, place.joints, tolerance);
                  }).find("must be 1e-9 to 1"),
                  std::string::npos);
}

TEST(OmplValidity, ThePlansOfAPlannerAreFree)
{
    Place place;
    for (const double angle : {0.5, 1.5, -0.8}) place.add_wire(1.3, angle);
    geometric::SimpleSetup setup(place.information);
    setup.setStartAndGoalStates(place.state(-2, 0.4), place.state(2.2, -0.3));
    setup.setPlanner(std::make_shared<geometric::RRTConnect>(place.information));
    ASSERT_TRUE(setup.solve(5.0));
    geometric::PathGeometric& path = setup.getSolutionPath();
    path.interpolate(20000);
    EXPECT_TRUE(std::ranges::all_of(path.getStates(), [&](const State* s) { return place.information->isValid(s); }));
}

} // namespace
} // namespace ompl::base
