// cuRobo's models of spheres, by yaml-cpp.
#include "robot/sphere_files.hpp"
#include "robot/yaml_file.hpp"

namespace oncollide::tools {

namespace {

/// The map of that name, at any level.
YAML::Node find(const YAML::Node& node, const std::string& name, int levels)
{
    if (!node.IsMap() || levels == 0) return YAML::Node(YAML::NodeType::Undefined);
    if (const YAML::Node found = node[name]; found && found.IsMap()) return found;
    for (const auto& child : node)
        if (YAML::Node found = find(child.second, name, levels - 1); found.IsDefined()) return found;
    return YAML::Node(YAML::NodeType::Undefined);
}

} // namespace

SphereModel read_yaml_spheres(const std::string& path, const RobotDescription& robot,
                              std::vector<std::string>& warnings)
{
    SphereModel model(robot.links.size());
    YamlFile::read(path, [&](const YamlFile& file) {
        const YAML::Node links = find(file.root(), "collision_spheres", 10);
        if (!links.IsDefined()) refuse(path, "has no map 'collision_spheres'");
        for (const auto& entry : links) {
            const int link = link_named(file.text(entry.first, "a link's name"), robot, warnings);
            for (const YAML::Node& sphere : file.list(entry.second, "the spheres of a link")) {
                const YAML::Node centre = sphere.IsMap() ? sphere["center"] : YAML::Node();
                if (!centre || !centre.IsSequence() || centre.size() != 3)
                    file.fail(sphere, "a sphere must have a 'center' of three numbers");
                const Eigen::Vector3d at(file.number(centre[0], "x"), file.number(centre[1], "y"),
                                         file.number(centre[2], "z"));
                const double radius = file.number(sphere["radius"], "radius");
                if (link >= 0 && radius > 0) model[static_cast<std::size_t>(link)].push_back({at, radius});
            }
        }
    });
    return model;
}

} // namespace oncollide::tools
