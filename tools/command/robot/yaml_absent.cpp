// Replaces the readers of YAML in builds without yaml-cpp.
#include "robot/planning_problem.hpp"
#include "robot/robot_padding.hpp"
#include "robot/sphere_files.hpp"

namespace oncollide::tools {

namespace {

[[noreturn]] void fail(const std::string& path)
{
    throw Error(ErrorKind::usage,
                path + ": this build cannot read YAML; build on Linux with yaml-cpp (Debian: libyaml-cpp-dev)");
}

} // namespace

SphereModel read_yaml_spheres(const std::string& path, const RobotDescription&, std::vector<std::string>&)
{
    fail(path);
}

PlanningProblem read_problem(const std::filesystem::path& scene, const std::filesystem::path&)
{
    fail(scene.string());
}

PaddingRules read_padding_file(const std::string& path, const PaddingNames&)
{
    fail(path);
}

} // namespace oncollide::tools
