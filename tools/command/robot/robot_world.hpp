#pragma once
#include <optional>
#include <string>
#include <vector>

#include <oncollide/robots/robot.hpp>
#include <oncollide/runs/pipeline.hpp>
#include <oncollide/scenes/scene.hpp>

#include "cli/arguments.hpp"

namespace oncollide::tools {

/// Options that name a robot and its environment.
struct RobotOptions {
    std::string urdf, srdf, world, base, data;
    std::vector<std::string> packages; ///< NAME=FOLDER
};
void add_robot_options(Arguments command, RobotOptions& options);

/// The description. Throws as load_robot.
RobotDescription open_robot(const RobotOptions& options);

/// A scene, or the body of one map or mesh, as a World.
struct RobotWorld {
    Scene scene;
    Pipeline pipeline;

    World& world() { return pipeline.world(); }
    /// "the body's name", or its number.
    std::string label(BodyId body) const;
};
RobotWorld open_robot_world(const RobotOptions& options, const Settings& settings);
Eigen::Isometry3d base_of(const RobotOptions& options);

/// Configurations from a file, or one.
struct ConfigurationOptions {
    std::string file, dataset = "configurations", group, state;
};
void add_configuration_options(Arguments command, ConfigurationOptions& options);
/// The numbers of all configurations. Columns with names are joints; other joints keep the state's numbers, or the
/// neutral ones. Throws Error{usage} or Error{bad_data}.
std::vector<double> open_configurations(const ConfigurationOptions& options, const Robot& robot);

} // namespace oncollide::tools
