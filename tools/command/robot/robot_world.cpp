#include "robot/robot_world.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "cli/options.hpp"
#include "common/numbers.hpp"
#include <oncollide/base/text/listed.hpp>
#include <oncollide/base/text/near_word.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>
#include <oncollide/scenes/files/tables/number_table.hpp>

namespace oncollide::tools {

void add_robot_options(Arguments command, RobotOptions& options)
{
    command
        .add_option("URDF URDF", options.urdf,
                    "robot: a URDF file (expanded by the program xacro, if necessary), or MuJoCo's MJCF")
        .required();
    command.add_option(
        "--srdf FILE", options.srdf,
        "SRDF file for a URDF: pairs of links that are not tested, groups, states (default: the links that "
        "a joint connects are not tested)");
    command
        .add_option(
            "--package NAME=FOLDER", options.packages,
            "folder of the meshes named package://NAME/... (default: found by its name, beside the URDF or above it)")
        .repeatable();
    command.add_option("--world SCENE|MAP", options.world,
                       "environment: a scene (file or name), an OctoMap, a terrain or a mesh (default: none)");
    command.add_option("--base \"x y z qx qy qz qw\"", options.base,
                       "pose of the root link, metres and unit quaternion");
    command.add_option("--data FOLDER", options.data, "folder of test models, for scenes that need them");
}

RobotDescription open_robot(const RobotOptions& options)
{
    RobotReading reading{.srdf = options.srdf, .packages = {}};
    for (const std::string& package : options.packages) {
        const std::size_t at = package.find('=');
        if (at == 0 || at >= package.size() - 1)
            throw Error(ErrorKind::usage, fmt::format("--package: '{}' is not NAME=FOLDER", printable(package)));
        reading.packages[package.substr(0, at)] = package.substr(at + 1);
    }
    return load_robot(options.urdf, reading);
}

Eigen::Isometry3d base_of(const RobotOptions& options)
{
    double length;
    const Eigen::Isometry3d pose = parse_pose("--base", options.base, length);
    if (!(std::abs(length - 1) <= 1e-3))
        refuse_numbers("--base", options.base, "the quaternion is not of length 1", "x y z qx qy qz qw");
    return pose;
}

namespace {

Scene scene_of(const RobotOptions& options)
{
    Scene scene;
    if (options.world.empty()) return scene;
    const bool is_scene = !is_scene_file(options.world) || options.world.ends_with(".json") || options.world == "-" ||
                          is_assembly_file(options.world);
    if (is_scene)
        return open_scene({.scene = options.world, .bodies = {}, .frames = {}, .seed = {}, .data = options.data});
    const GeometryId geometry = scene.add(options.world, std::move(load_geometry(options.world)->data));
    scene.add_body({.name = options.world, .geometry = geometry, .is_static = true});
    return scene;
}

} // namespace

RobotWorld open_robot_world(const RobotOptions& options, const Settings& settings)
{
    Scene scene = scene_of(options);
    Pipeline pipeline(scene, settings);
    return {std::move(scene), std::move(pipeline)};
}

std::string RobotWorld::label(BodyId body) const
{
    return printable(scene.label(SceneBodyId{body.slot}));
}

void add_configuration_options(Arguments command, ConfigurationOptions& options)
{
    command.add_option("--configurations FILE", options.file,
                       "file of configurations, one a row: .csv (a first line may name joints), .npy or .h5 (default: "
                       "the state alone)");
    command.add_option("--dataset PATH", options.dataset,
                       "path of the configurations in an HDF5 file (default configurations)");
    command.add_option("--group NAME", options.group, "the columns are the joints of this group of the SRDF");
    command.add_option("--state NAME", options.state,
                       "state of the SRDF, for joints without a column (default: 0, or the nearest limit)");
}

namespace {

/// The number of the configuration that each column sets.
std::vector<std::size_t> columns_of(const ConfigurationOptions& options, const Robot& robot, const NumberTable& table)
{
    const std::vector<std::string>& names = robot.names();
    std::vector<std::size_t> columns;
    if (!table.names.empty()) {
        for (const std::string& name : table.names) {
            const auto found = std::ranges::find(names, name);
            if (found == names.end())
                refuse(options.file, fmt::format("line 1: no joint '{}'{}", printable(name),
                                                 printable(valid_names(name, {names.begin(), names.end()}))));
            columns.push_back(static_cast<std::size_t>(found - names.begin()));
            if (std::ranges::count(columns, columns.back()) > 1)
                refuse(options.file, fmt::format("line 1: joint '{}' has two columns", printable(name)));
        }
        return columns;
    }
    const RobotDescription& description = robot.description();
    const auto group = std::ranges::find(description.groups, options.group, &RobotGroup::name);
    if (!options.group.empty() && group == description.groups.end()) {
        std::vector<std::string_view> known;
        for (const RobotGroup& each : description.groups) known.push_back(each.name);
        usage(fmt::format("--group: no group '{}'{}", printable(options.group),
                          printable(valid_names(options.group, known))));
    }
    for (std::size_t i = 0; i < names.size(); ++i) {
        const std::string joint = names[i].substr(0, names[i].find('/'));
        const bool mine = options.group.empty() || std::ranges::any_of(group->joints, [&](std::uint32_t j) {
                              return description.joints[j].name == names[i] || description.joints[j].name == joint;
                          });
        if (mine) columns.push_back(i);
    }
    if (columns.size() != table.columns)
        refuse(options.file,
               fmt::format("has {} columns; {} has {} numbers: {}", table.columns,
                           options.group.empty() ? "a configuration" : "group " + printable(options.group),
                           columns.size(), [&] {
                               std::vector<std::string_view> list;
                               for (const std::size_t i : columns) list.push_back(names[i]);
                               return printable(listed(list));
                           }()));
    return columns;
}

} // namespace

std::vector<double> open_configurations(const ConfigurationOptions& options, const Robot& robot)
{
    std::vector<double> start = robot.neutral();
    if (!options.state.empty()) robot.apply_state(options.state, options.group, start);
    if (options.file.empty()) return start;
    const NumberTable table = load_number_table(options.file, options.dataset);
    const std::vector<std::size_t> columns = columns_of(options, robot, table);
    std::vector<double> all;
    all.reserve(table.rows() * start.size());
    for (std::size_t row = 0; row < table.rows(); ++row) {
        all.insert(all.end(), start.begin(), start.end());
        double* const mine = all.data() + row * start.size();
        for (std::size_t k = 0; k < columns.size(); ++k) mine[columns[k]] = table.numbers[row * table.columns + k];
    }
    return all;
}

} // namespace oncollide::tools
