#include "bench/robot/robot_place.hpp"

#include <algorithm>
#include <cmath>

namespace oncollide::tools {

void add_problem_options(BenchmarkCommand& command, ProblemOptions& options)
{
    command.input("URDF URDF", options.robot.urdf, "robot").required();
    command.input("--srdf FILE", options.robot.srdf, "SRDF file").required();
    command.option("--package NAME=FOLDER", options.robot.packages, "folder of the meshes named package://NAME/...")
        .repeatable();
    command.option("--problems FOLDER", options.problems, "folder of MotionBenchMaker's problems, unpacked").required();
    command.whole("--most N", options.most, "problems of each set at most; 0: all", {0});
}

std::vector<PlanningProblem> open_problems(const ProblemOptions& options)
{
    return load_problems(options.problems, static_cast<std::size_t>(options.most));
}

RobotWork workload_of(const PlanningProblem& problem, const Robot& robot, int each)
{
    if (std::ranges::none_of(robot.names(), [&](const std::string& name) { return problem.goal.contains(name); }))
        refuse(
            fmt::format("{}/request{}.yaml", printable(problem.set), printable(problem.name)),
            fmt::format("its goal has no joint of '{}'; is it of another robot?", printable(robot.description().name)));
    RobotWork work;
    std::vector<double> from = robot.neutral(), to;
    const auto set = [&](std::vector<double>& numbers, const std::map<std::string, double>& values) {
        for (std::size_t i = 0; i < numbers.size(); ++i)
            if (const auto found = values.find(robot.names()[i]); found != values.end()) numbers[i] = found->second;
    };
    set(from, problem.start);
    to = from;
    set(to, problem.goal);
    for (int k = 0; k < each; ++k) {
        const double at = each == 1 ? 0 : double(k) / double(each - 1);
        for (std::size_t i = 0; i < from.size(); ++i) work.numbers.push_back((1 - at) * from[i] + at * to[i]);
    }
    for (const PlanningProblem::Obstacle& obstacle : problem.obstacles)
        work.obstacles.push_back(
            {std::make_shared<const Geometry>(Geometry{obstacle.name, obstacle.shape, {}}), obstacle.pose});
    return work;
}

RobotDescription with_spheres(RobotDescription robot, const SphereModel& model)
{
    for (std::size_t i = 0; i < robot.links.size(); ++i) {
        robot.links[i].collision.clear();
        for (const CoverSphere& sphere : model[i]) {
            Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
            pose.translation() = sphere.centre;
            robot.links[i].collision.push_back(
                {std::make_shared<const Geometry>(Geometry{robot.links[i].name, Sphere{sphere.radius}, {}}), pose});
        }
    }
    return robot;
}

void RobotPlace::set_obstacles(const std::vector<LinkGeometry>& obstacles)
{
    world.bodies().remove(bodies_);
    for (const ModelId model : models_) world.models().remove(model);
    bodies_.clear(), models_.clear();
    for (const LinkGeometry& obstacle : obstacles) {
        models_.push_back(world.models().add(obstacle.geometry));
        bodies_.push_back(world.bodies().add({.model = models_.back(), .pose = obstacle.pose, .is_static = true}));
    }
}

bool MotionSamples::collide(std::span<const double> from, std::span<const double> to, std::size_t first,
                            std::size_t last, std::size_t parts)
{
    numbers_.clear();
    for (std::size_t k = first; k <= last; ++k)
        for (std::size_t i = 0; i < from.size(); ++i)
            numbers_.push_back(std::lerp(from[i], to[i], static_cast<double>(k) / static_cast<double>(parts)));
    found_.resize(numbers_.size() / from.size());
    place_.robot.check(place_.world, numbers_, found_);
    return std::ranges::any_of(found_, [](const RobotFinding& f) { return f.verdict != Verdict::separate; });
}

} // namespace oncollide::tools
