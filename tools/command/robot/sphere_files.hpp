#pragma once
#include <string>
#include <vector>

#include <oncollide/robots/cover.hpp>
#include <oncollide/robots/robot.hpp>

namespace oncollide::tools {

/// The spheres of each link of a robot, in the link's frame.
using SphereModel = std::vector<std::vector<CoverSphere>>;

std::size_t count_of(const SphereModel& model);

/// Reads a model of the robot: cuRobo's YAML (`collision_spheres` by link, at any level), a URDF whose collision
/// geometry is spheres, or CSV (link,x,y,z,radius). Spheres without a positive radius are left out. Links of the model
/// that the robot does not have are named in `warnings`. Throws Error{no_input} and Error{bad_data}.
SphereModel load_sphere_model(const std::string& path, const RobotDescription& robot,
                              std::vector<std::string>& warnings);
/// A map from links to lists of spheres in YAML, as cuRobo has it.
SphereModel read_yaml_spheres(const std::string& path, const RobotDescription& robot,
                              std::vector<std::string>& warnings);
/// The number of a link; -1, with a warning, for a link that the robot does not have.
int link_named(const std::string& name, const RobotDescription& robot, std::vector<std::string>& warnings);

void save_yaml_spheres(const std::string& path, const RobotDescription& robot, const SphereModel& model);
void save_csv_spheres(const std::string& path, const RobotDescription& robot, const SphereModel& model);
/// A URDF file of the robot's links and joints, with spheres as the collision geometry; without visual geometry and
/// masses.
void save_urdf_spheres(const std::string& path, const RobotDescription& robot, const SphereModel& model);

} // namespace oncollide::tools
