#include "contenders.hpp"

#include <algorithm>
#include <numbers>
#include <set>

#include <oncollide/base/numbers/random.hpp>

#include "peers/fcl_robot.hpp"

namespace oncollide::tools {

namespace ob = ompl::base;

Moving moving_of(const PlanningProblem& problem, const Robot& robot)
{
    Moving moving;
    const std::size_t width = robot.width();
    const std::vector<double> ends = workload_of(problem, robot, 2).numbers;
    moving.start.assign(ends.begin(), ends.begin() + static_cast<std::ptrdiff_t>(width));
    moving.goal.assign(ends.begin() + static_cast<std::ptrdiff_t>(width), ends.end());
    for (const std::string& name : robot.names())
        if (problem.goal.contains(name)) moving.names.push_back(name);
    return moving;
}

namespace {

/// The states of a robot, with a checker of them that counts.
std::shared_ptr<CountedStates> count_states(const ob::SpaceInformationPtr& information,
                                            std::shared_ptr<ob::StateValidityChecker> checker)
{
    auto counted = std::make_shared<CountedStates>(information, std::move(checker));
    information->setStateValidityChecker(counted);
    return counted;
}

class FclStates final : public ob::StateValidityChecker {
public:
    FclStates(const ob::SpaceInformationPtr& information, const ob::OncollideJoints& joints, FclRobot& robot)
        : StateValidityChecker(information), states_(*information, joints), robot_(robot),
          poses_(joints.robot().description().links.size())
    {
    }
    bool isValid(const ob::State* state) const override
    {
        states_.joints().robot().link_poses(states_.configuration(state), poses_);
        return !robot_.collides(poses_);
    }

private:
    ob::OncollideStates states_;
    FclRobot& robot_;
    mutable std::vector<Eigen::Isometry3d> poses_;
};

class FclContender final : public PlanContender {
public:
    explicit FclContender(const RobotDescription& robot)
        : PlanContender("FCL, sampled"), place_(robot, {}), robot_(robot)
    {
    }
    std::shared_ptr<CountedStates> begin(const RobotWork& work, const Moving& moving,
                                         ob::SpaceInformationPtr& information) override
    {
        robot_.set_environment(work.obstacles);
        const ob::OncollideJoints joints(place_.world, place_.robot, moving.names, moving.start);
        information = std::make_shared<ob::SpaceInformation>(joints.makeStateSpace());
        return count_states(information, std::make_shared<FclStates>(information, joints, robot_));
    }

private:
    RobotPlace place_; ///< for the poses of links
    FclRobot robot_;
};

} // namespace

std::shared_ptr<CountedStates> OurContender::begin(const RobotWork& work, const Moving& moving,
                                                   ob::SpaceInformationPtr& information)
{
    place_.set_obstacles(work.obstacles);
    const ob::OncollideJoints joints(place_.world, place_.robot, moving.names, moving.start);
    information = std::make_shared<ob::SpaceInformation>(joints.makeStateSpace());
    if (certified_)
        information->setMotionValidator(std::make_shared<ob::OncollideMotionValidator>(information, joints));
    return count_states(information, std::make_shared<ob::OncollideStateValidityChecker>(information, joints));
}

std::unique_ptr<PlanContender> fcl_contender(const RobotDescription& robot)
{
    return std::make_unique<FclContender>(robot);
}

RobotDescription without_pairs_that_always_overlap(RobotDescription description)
{
    World world;
    const Robot robot(world, description);
    std::vector<double> numbers(robot.width());
    std::vector<Eigen::Isometry3d> poses(description.links.size());
    const auto overlap = [&](std::size_t a, std::size_t b) {
        for (const LinkGeometry& one : description.links[a].collision)
            for (const LinkGeometry& other : description.links[b].collision) {
                const double radii = std::get<Sphere>(std::get<Shape>(one.geometry->data)).radius +
                                     std::get<Sphere>(std::get<Shape>(other.geometry->data)).radius;
                if (((poses[a] * one.pose).translation() - (poses[b] * other.pose).translation()).norm() <= radii)
                    return true;
            }
        return false;
    };
    std::set<std::pair<std::uint32_t, std::uint32_t>> always;
    for (std::uint32_t b = 0; b < poses.size(); ++b)
        for (std::uint32_t a = 0; a < b; ++a) always.insert({a, b});
    for (std::uint64_t k = 0; k < 200; ++k) {
        for (std::size_t i = 0; i < numbers.size(); ++i) {
            const auto joint = std::ranges::find(description.joints, robot.names()[i], &RobotJoint::name);
            if (joint == description.joints.end()) continue;
            const double low = std::max(joint->lower, -std::numbers::pi),
                         high = std::min(joint->upper, std::numbers::pi);
            numbers[i] = low + u01(1, k, i) * (high - low);
        }
        robot.link_poses(numbers, poses);
        std::erase_if(always, [&](const auto& pair) { return !overlap(pair.first, pair.second); });
    }
    always.insert(description.excluded.begin(), description.excluded.end());
    description.excluded.assign(always.begin(), always.end());
    return description;
}

} // namespace oncollide::tools
