// A robot among the obstacles of a planning problem.
#pragma once
#include "bench/common/benchmark.hpp"
#include "robot/planning_problem.hpp"
#include "robot/robot_world.hpp"
#include "robot/sphere_files.hpp"

namespace oncollide::tools {

/// A robot and MotionBenchMaker's problems.
struct ProblemOptions {
    RobotOptions robot;
    std::string problems;
    int most = 0; ///< of each set; 0: all
};
void add_problem_options(BenchmarkCommand& command, ProblemOptions& options);
std::vector<PlanningProblem> open_problems(const ProblemOptions& options);

/// Configurations between the start and the goal of a problem, and its obstacles.
struct RobotWork {
    std::vector<double> numbers;
    std::vector<LinkGeometry> obstacles;
};
/// `each` configurations. Joints that the robot has not are left out. Throws Error{bad_data} if it has none of the
/// goal's.
RobotWork workload_of(const PlanningProblem& problem, const Robot& robot, int each);

/// The robot with spheres as its collision geometry.
RobotDescription with_spheres(RobotDescription robot, const SphereModel& model);

/// A World with the robot and the obstacles of one problem after another.
struct RobotPlace {
    World world;
    Robot robot;

    RobotPlace(const RobotDescription& description, const Settings& settings)
        : world(settings), robot(world, description)
    {
    }
    void set_obstacles(const std::vector<LinkGeometry>& obstacles);
    std::span<const BodyId> obstacles() const { return bodies_; }

private:
    std::vector<ModelId> models_;
    std::vector<BodyId> bodies_;
};

/// Checks evenly spaced configurations of motions. Keeps its memory.
class MotionSamples {
public:
    explicit MotionSamples(const RobotPlace& place) : place_(place) {}
    /// Whether the configuration at one of the shares first / parts, ..., last / parts of a motion is not separate.
    bool collide(std::span<const double> from, std::span<const double> to, std::size_t first, std::size_t last,
                 std::size_t parts);

private:
    const RobotPlace& place_;
    std::vector<double> numbers_;
    std::vector<RobotFinding> found_;
};

} // namespace oncollide::tools
