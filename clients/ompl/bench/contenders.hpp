// Ways to check states and motions while RRT-Connect plans.
#pragma once
#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include <oncollide/ompl/validity.hpp>

#include "bench/robot/robot_place.hpp"

namespace oncollide::tools {

/// Passes states on to a checker and counts them.
class CountedStates : public ompl::base::StateValidityChecker {
public:
    CountedStates(const ompl::base::SpaceInformationPtr& information, ompl::base::StateValidityCheckerPtr checker)
        : StateValidityChecker(information), checker_(std::move(checker))
    {
    }
    bool isValid(const ompl::base::State* state) const override
    {
        count_.fetch_add(1, std::memory_order_relaxed);
        return checker_->isValid(state);
    }
    std::size_t count() const { return count_; }

private:
    ompl::base::StateValidityCheckerPtr checker_;
    mutable std::atomic<std::size_t> count_ = 0;
};

/// The joints that a problem moves, and the configuration of the others.
struct Moving {
    std::vector<std::string> names;
    std::vector<double> start, goal; ///< whole configurations
};
Moving moving_of(const PlanningProblem& problem, const Robot& robot);

class PlanContender {
public:
    explicit PlanContender(std::string name) : name_(std::move(name)) {}
    virtual ~PlanContender() = default;
    /// Makes the states of a problem and their checker. The motion validator is OMPL's unless it is set.
    virtual std::shared_ptr<CountedStates> begin(const RobotWork& work, const Moving& moving,
                                                 ompl::base::SpaceInformationPtr& information) = 0;
    virtual bool certified() const { return false; }
    const std::string& name() const { return name_; }

private:
    std::string name_;
};

/// The robot with meshes or with spheres; motions certified or sampled.
class OurContender final : public PlanContender {
public:
    OurContender(std::string name, const RobotDescription& robot, bool certified)
        : PlanContender(std::move(name)), place_(robot, {}), certified_(certified)
    {
    }
    std::shared_ptr<CountedStates> begin(const RobotWork& work, const Moving& moving,
                                         ompl::base::SpaceInformationPtr& information) override;
    bool certified() const override { return certified_; }

private:
    RobotPlace place_;
    bool certified_;
};

/// FCL, as MoveIt has it; motions sampled.
std::unique_ptr<PlanContender> fcl_contender(const RobotDescription& robot);

/// Excludes the pairs of links whose spheres overlap in each of 200 random configurations: no plan could begin.
RobotDescription without_pairs_that_always_overlap(RobotDescription robot);

} // namespace oncollide::tools
