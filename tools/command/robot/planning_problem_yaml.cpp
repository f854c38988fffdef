// MotionBenchMaker's scenes and requests: messages of MoveIt as YAML.
#include "robot/planning_problem.hpp"

#include "robot/yaml_file.hpp"

#include <fmt/format.h>

namespace oncollide::tools {

namespace {

std::vector<double> numbers(const YamlFile& file, const YAML::Node& node, std::size_t count, const char* what)
{
    if (!node || !node.IsSequence() || (count && node.size() != count))
        file.fail(node, fmt::format("{} must be a list of {} numbers", what, count));
    std::vector<double> list;
    for (const YAML::Node& one : node) list.push_back(file.number(one, what));
    return list;
}

Eigen::Isometry3d pose_of(const YamlFile& file, const YAML::Node& node)
{
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    if (!node) return pose;
    const std::vector<double> at = numbers(file, node["position"], 3, "position");
    const std::vector<double> q = numbers(file, node["orientation"], 4, "orientation");
    const Eigen::Quaterniond rotation(q[3], q[0], q[1], q[2]);
    if (!(std::abs(rotation.norm() - 1) <= 1e-3)) file.fail(node, "the orientation is not of length 1");
    pose.linear() = rotation.normalized().toRotationMatrix();
    pose.translation() << at[0], at[1], at[2];
    return pose;
}

Shape shape_of(const YamlFile& file, const YAML::Node& node)
{
    const std::string type = file.text(node["type"], "type");
    const auto size = [&](std::size_t count) { return numbers(file, node["dimensions"], count, "dimensions"); };
    Shape shape;
    if (type == "box") {
        const std::vector<double> n = size(3);
        shape = Box{Eigen::Vector3d(n[0], n[1], n[2]) / 2};
    } else if (type == "cylinder") {
        const std::vector<double> n = size(2);
        shape = Cylinder{n[1], n[0]};
    } else if (type == "sphere") {
        shape = Sphere{size(1)[0]};
    } else {
        file.fail(node, fmt::format("unknown primitive '{}'", printable(type)));
    }
    check_shape(file.path(), shape);
    return shape;
}

void read_scene(const YamlFile& file, PlanningProblem& problem)
{
    for (const YAML::Node& object : file.list(file.root()["world"]["collision_objects"], "world.collision_objects")) {
        const Eigen::Isometry3d pose = pose_of(file, object["pose"]);
        const YAML::Node shapes = file.list(object["primitives"], "primitives"),
                         poses = file.list(object["primitive_poses"], "primitive_poses");
        if (shapes.size() != poses.size()) file.fail(object, "primitives and primitive_poses have different lengths");
        for (std::size_t i = 0; i < shapes.size(); ++i)
            problem.obstacles.push_back(
                {file.text(object["id"], "id"), shape_of(file, shapes[i]), pose * pose_of(file, poses[i])});
    }
}

void read_request(const YamlFile& file, PlanningProblem& problem)
{
    const YAML::Node state = file.root()["start_state"]["joint_state"];
    const YAML::Node names = file.list(state["name"], "start_state.joint_state.name"),
                     positions = file.list(state["position"], "start_state.joint_state.position");
    if (names.size() != positions.size()) file.fail(state, "name and position have different lengths");
    for (std::size_t i = 0; i < names.size(); ++i)
        problem.start[file.text(names[i], "name")] = file.number(positions[i], "position");
    const YAML::Node goals = file.list(file.root()["goal_constraints"], "goal_constraints");
    if (goals.size() == 0) file.fail(goals, "there is no goal");
    for (const YAML::Node& joint : file.list(goals[0]["joint_constraints"], "joint_constraints"))
        problem.goal[file.text(joint["joint_name"], "joint_name")] = file.number(joint["position"], "position");
}

} // namespace

PlanningProblem read_problem(const std::filesystem::path& scene, const std::filesystem::path& request)
{
    PlanningProblem problem;
    YamlFile::read(scene.string(), [&](const YamlFile& file) { read_scene(file, problem); });
    YamlFile::read(request.string(), [&](const YamlFile& file) { read_request(file, problem); });
    return problem;
}

} // namespace oncollide::tools
