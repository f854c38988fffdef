#pragma once
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <ompl/base/MotionValidator.h>
#include <ompl/base/SpaceInformation.h>
#include <ompl/base/StateValidityChecker.h>

#include <oncollide/pipeline/world.hpp>
#include <oncollide/robots/robot.hpp>

namespace ompl::base {

/// Numbers of a robot's configurations, one for each value of a state; the other numbers rest. World and robot must
/// outlive it and must not change while a planner runs. The World's settings decide whether checks are exact or within
/// an error.
class OncollideJoints {
public:
    /// @param names  of numbers (Robot::names()), in the order of the states' values
    /// @param rest   a configuration; empty: neutral()
    /// Throws Exception for a name that the robot has not or that is listed twice, for floating joints, and
    /// oncollide::Error for a World or a configuration that is not the robot's.
    OncollideJoints(const oncollide::World& world, const oncollide::Robot& robot, const std::vector<std::string>& names,
                    std::vector<double> rest = {}, const oncollide::RobotCheck& pairs = {});
    /// All joints of a group of the SRDF file that have numbers. Throws Exception for an unknown group.
    static OncollideJoints ofGroup(const oncollide::World& world, const oncollide::Robot& robot,
                                   const std::string& group, std::vector<double> rest = {},
                                   const oncollide::RobotCheck& pairs = {});

    /// A RealVectorStateSpace with the joints' limits. With continuous joints: a CompoundStateSpace in which these are
    /// SO2StateSpaces. Throws Exception for another joint without limits.
    StateSpacePtr makeStateSpace() const;

    const oncollide::World& world() const { return *world_; }
    const oncollide::Robot& robot() const { return *robot_; }
    const oncollide::RobotCheck& pairs() const { return pairs_; }
    const std::vector<double>& rest() const { return rest_; }
    const std::vector<std::size_t>& numbers() const { return numbers_; } ///< by value: its place in a configuration

private:
    const oncollide::World* world_;
    const oncollide::Robot* robot_;
    oncollide::RobotCheck pairs_;
    std::vector<double> rest_;
    std::vector<std::size_t> numbers_;
};

/// Translates states of a space into configurations.
class OncollideStates {
public:
    /// Throws Exception unless the space has as many values as there are joints and interpolates them at constant
    /// speed, as RealVectorStateSpace, SO2StateSpace and compounds of these do.
    OncollideStates(const SpaceInformation& information, OncollideJoints joints);

    const OncollideJoints& joints() const { return joints_; }
    std::vector<double> configuration(const State* state) const;
    /// The configuration at the end of the motion: angles of SO2StateSpace take the shorter way.
    std::vector<double> end(const std::vector<double>& start, const State* state) const;
    bool isSeparate(const State* state) const;

private:
    struct Value {
        StateSpace::ValueLocation location;
        std::size_t number;
        bool angle;
    };
    void checkMotions() const;

    StateSpacePtr space_;
    OncollideJoints joints_;
    std::vector<Value> values_;
};

/// A state is valid if the robot is separate from itself and from the World's bodies; verdicts `within` and `undecided`
/// are not valid. Bounds are not checked: interpolation stays within them. May be called from many threads.
class OncollideStateValidityChecker : public StateValidityChecker {
public:
    OncollideStateValidityChecker(const SpaceInformationPtr& information, OncollideJoints joints);
    bool isValid(const State* state) const override;

private:
    OncollideStates states_;
};

/// A motion is valid if it is certified that there is no contact at any of its states. May be called from many threads,
/// which DiscreteMotionValidator's counters do not allow.
class OncollideMotionValidator : public MotionValidator {
public:
    /// @param tolerance  RobotEdgeCheck::tolerance
    /// Throws Exception for a tolerance that is not 1e-9 to 1.
    OncollideMotionValidator(const SpaceInformationPtr& information, OncollideJoints joints, double tolerance = 1e-4);
    bool checkMotion(const State* s1, const State* s2) const override;
    /// lastValid.second: all states before it are certified, and the state there is valid. A state in contact is at
    /// most a few tolerances later, unless the pair stays undecided.
    bool checkMotion(const State* s1, const State* s2, std::pair<State*, double>& lastValid) const override;

private:
    oncollide::RobotEdgeFinding find(const State* s1, const State* s2, bool first) const;
    bool count(bool valid) const;

    OncollideStates states_;
    double tolerance_;
};

/// Sets both.
void setOncollideValidity(const SpaceInformationPtr& information, const OncollideJoints& joints,
                          double tolerance = 1e-4);

} // namespace ompl::base
