#include <oncollide/ompl/validity.hpp>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/base/spaces/SO2StateSpace.h>
#include <ompl/util/Exception.h>

namespace ompl::base {
namespace {

using oncollide::JointKind, oncollide::Robot, oncollide::RobotJoint, oncollide::Verdict;

/// The joint of a number: JOINT or JOINT/x.
const RobotJoint& joint_of(const Robot& robot, const std::string& name)
{
    const std::vector<RobotJoint>& joints = robot.description().joints;
    const auto named = [](const std::string& wanted) {
        return [&wanted](const RobotJoint& joint) { return joint.name == wanted; };
    };
    const auto whole = std::ranges::find_if(joints, named(name));
    return whole != joints.end() ? *whole : *std::ranges::find_if(joints, named(name.substr(0, name.rfind('/'))));
}

std::string listed(const std::vector<std::string>& names)
{
    std::string all;
    for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
    return all.empty() ? "none" : all;
}

std::vector<std::string> names_of(const Robot& robot, const std::string& group)
{
    for (const oncollide::RobotGroup& one : robot.description().groups)
        if (one.name == group) {
            std::vector<std::string> names;
            for (const std::string& name : robot.names())
                for (const std::uint32_t joint : one.joints)
                    if (&joint_of(robot, name) == &robot.description().joints[joint]) names.push_back(name);
            return names;
        }
    std::vector<std::string> known;
    for (const oncollide::RobotGroup& one : robot.description().groups) known.push_back(one.name);
    throw Exception("oncollide",
                    "robot '" + robot.description().name + "' has no group '" + group + "'; it has: " + listed(known));
}

double shorter(double angle)
{
    return std::abs(angle) <= std::numbers::pi ? angle : angle - std::copysign(2 * std::numbers::pi, angle);
}

} // namespace

OncollideJoints::OncollideJoints(const oncollide::World& world, const Robot& robot,
                                 const std::vector<std::string>& names, std::vector<double> rest,
                                 const oncollide::RobotCheck& pairs)
    : world_(&world), robot_(&robot), pairs_(pairs), rest_(rest.empty() ? robot.neutral() : std::move(rest))
{
    for (const std::string& name : names) {
        const auto at = std::ranges::find(robot.names(), name);
        if (at == robot.names().end())
            throw Exception("oncollide", "the configurations of robot '" + robot.description().name + "' have no '" +
                                             name + "'; they have: " + listed(robot.names()));
        if (joint_of(robot, name).kind == JointKind::floating)
            throw Exception("oncollide", "joint '" + joint_of(robot, name).name +
                                             "' is floating; states can have revolute, continuous, prismatic and "
                                             "planar joints");
        const auto number = static_cast<std::size_t>(at - robot.names().begin());
        if (std::ranges::find(numbers_, number) != numbers_.end())
            throw Exception("oncollide", "'" + name + "' is listed twice");
        numbers_.push_back(number);
    }
    if (numbers_.empty()) throw Exception("oncollide", "no joint of the robot moves");
    oncollide::RobotFinding found;
    robot.check(world, rest_, {&found, 1}, pairs_); // throws if they do not belong together
}

OncollideJoints OncollideJoints::ofGroup(const oncollide::World& world, const Robot& robot, const std::string& group,
                                         std::vector<double> rest, const oncollide::RobotCheck& pairs)
{
    return {world, robot, names_of(robot, group), std::move(rest), pairs};
}

StateSpacePtr OncollideJoints::makeStateSpace() const
{
    std::vector<StateSpacePtr> spaces; // real numbers in a row share one
    std::shared_ptr<RealVectorStateSpace> real;
    for (const std::size_t number : numbers_) {
        const RobotJoint& joint = joint_of(*robot_, robot_->names()[number]);
        const bool limited =
            joint.kind != JointKind::planar && std::isfinite(joint.lower) && std::isfinite(joint.upper);
        if (joint.kind != JointKind::continuous && !limited)
            throw Exception("oncollide",
                            "joint '" + joint.name + "' has no limits; make a state space with bounds for it");
        if (joint.kind == JointKind::continuous) {
            spaces.push_back(std::make_shared<SO2StateSpace>());
            real.reset();
        } else {
            if (!real) spaces.push_back(real = std::make_shared<RealVectorStateSpace>());
            real->addDimension(joint.name, joint.lower, joint.upper);
        }
    }
    if (spaces.size() == 1) return spaces.front();
    return std::make_shared<CompoundStateSpace>(spaces, std::vector<double>(spaces.size(), 1.0));
}

OncollideStates::OncollideStates(const SpaceInformation& information, OncollideJoints joints)
    : space_(information.getStateSpace()), joints_(std::move(joints))
{
    space_->computeLocations();
    const std::vector<StateSpace::ValueLocation>& locations = space_->getValueLocations();
    if (locations.size() != joints_.numbers().size())
        throw Exception("oncollide", "states of '" + space_->getName() + "' have " + std::to_string(locations.size()) +
                                         " values, but " + std::to_string(joints_.numbers().size()) +
                                         " numbers of the robot move");
    for (std::size_t i = 0; i < locations.size(); ++i)
        values_.push_back(
            {locations[i], joints_.numbers()[i], locations[i].stateLocation.space->getType() == STATE_SPACE_SO2});
    checkMotions();
}

/// check_edges() certifies motions at constant speed: other interpolations, as in Dubins' space, are refused.
void OncollideStates::checkMotions() const
{
    State *from = space_->allocState(), *to = space_->allocState(), *between = space_->allocState();
    for (std::size_t i = 0; i < values_.size(); ++i) {
        const double sign = i % 2 ? 1 : -1, part = 1.0 / static_cast<double>(i + 2);
        *space_->getValueAddressAtLocation(from, values_[i].location) = sign * (2.5 - part);
        *space_->getValueAddressAtLocation(to, values_[i].location) = -sign * (2.0 + part);
    }
    bool equal = true;
    for (const double share : {0.1, 0.6}) {
        space_->interpolate(from, to, share, between);
        const std::vector<double> a = configuration(from), b = end(a, to), at = configuration(between);
        for (const Value& value : values_) {
            const double off = at[value.number] - (a[value.number] + share * (b[value.number] - a[value.number]));
            equal = equal && std::abs(value.angle ? std::remainder(off, 2 * std::numbers::pi) : off) < 1e-9;
        }
    }
    for (State* state : {from, to, between}) space_->freeState(state);
    if (!equal)
        throw Exception("oncollide", "'" + space_->getName() +
                                         "' does not interpolate values at constant speed; use RealVectorStateSpace, "
                                         "SO2StateSpace or compounds of them");
}

std::vector<double> OncollideStates::configuration(const State* state) const
{
    std::vector<double> numbers = joints_.rest();
    for (const Value& value : values_)
        numbers[value.number] = *space_->getValueAddressAtLocation(state, value.location);
    return numbers;
}

std::vector<double> OncollideStates::end(const std::vector<double>& start, const State* state) const
{
    std::vector<double> numbers = configuration(state);
    for (const Value& value : values_)
        if (value.angle)
            numbers[value.number] = start[value.number] + shorter(numbers[value.number] - start[value.number]);
    return numbers;
}

bool OncollideStates::isSeparate(const State* state) const
{
    oncollide::RobotFinding found;
    joints_.robot().check(joints_.world(), configuration(state), {&found, 1}, joints_.pairs());
    return found.verdict == Verdict::separate;
}

OncollideStateValidityChecker::OncollideStateValidityChecker(const SpaceInformationPtr& information,
                                                             OncollideJoints joints)
    : StateValidityChecker(information), states_(*information, std::move(joints))
{
}

bool OncollideStateValidityChecker::isValid(const State* state) const
{
    return states_.isSeparate(state);
}

OncollideMotionValidator::OncollideMotionValidator(const SpaceInformationPtr& information, OncollideJoints joints,
                                                   double tolerance)
    : MotionValidator(information), states_(*information, std::move(joints)), tolerance_(tolerance)
{
    if (!(tolerance >= 1e-9 && tolerance <= 1))
        throw Exception("oncollide", "tolerance " + std::to_string(tolerance) + ": must be 1e-9 to 1");
}

oncollide::RobotEdgeFinding OncollideMotionValidator::find(const State* s1, const State* s2, bool first) const
{
    const std::vector<double> from = states_.configuration(s1), to = states_.end(from, s2);
    oncollide::RobotEdgeFinding found;
    const OncollideJoints& joints = states_.joints();
    joints.robot().check_edges(joints.world(), from, to, {&found, 1},
                               {.pairs = joints.pairs(), .tolerance = tolerance_, .first = first});
    return found;
}

bool OncollideMotionValidator::count(bool valid) const
{
    __atomic_fetch_add(valid ? &valid_ : &invalid_, 1u, __ATOMIC_RELAXED); // planners with several threads share it
    return valid;
}

bool OncollideMotionValidator::checkMotion(const State* s1, const State* s2) const
{
    return count(find(s1, s2, false).verdict == Verdict::separate);
}

bool OncollideMotionValidator::checkMotion(const State* s1, const State* s2, std::pair<State*, double>& lastValid) const
{
    const oncollide::RobotEdgeFinding found = find(s1, s2, true);
    if (found.verdict == Verdict::separate) return count(true);
    // States before clear_until are certified; the one there, and after rounding those beside it, may be in contact.
    State* last = si_->allocState();
    double time = found.clear_until;
    for (double back = tolerance_; time > 0; time -= back, back *= 2) {
        si_->getStateSpace()->interpolate(s1, s2, time, last);
        if (states_.isSeparate(last)) break;
    }
    if (time <= 0) si_->copyState(last, s1), time = 0;
    if (lastValid.first) si_->copyState(lastValid.first, last); // may be s1 or s2
    lastValid.second = time;
    si_->freeState(last);
    return count(false);
}

void setOncollideValidity(const SpaceInformationPtr& information, const OncollideJoints& joints, double tolerance)
{
    information->setStateValidityChecker(std::make_shared<OncollideStateValidityChecker>(information, joints));
    information->setMotionValidator(std::make_shared<OncollideMotionValidator>(information, joints, tolerance));
}

} // namespace ompl::base
