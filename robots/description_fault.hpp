#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include <oncollide/robots/robot.hpp>

namespace oncollide {

/// Numbers of configurations are up to this, m or rad.
constexpr double most_joint_number = 1e9;

/// How many numbers of a configuration are the joint's own.
int numbers_of(const RobotJoint& joint);

/// A fault of a description. Readers add the file and the line, Robot the names.
struct DescriptionFault {
    enum class Of : std::uint8_t { robot, link, joint, excluded, group, state };
    Of of = Of::robot;
    std::uint32_t number = 0; ///< its number in the description's list
    std::string what;
};

/// The first fault of a description from any source: sizes, numbers, names, geometries, and the tree of links. Cost: as
/// check_geometry() of all geometries; otherwise linear.
std::optional<DescriptionFault> fault_of(const RobotDescription& robot);

/// Throws Error{bad_data} for the first fault: "robot 'arm': joint 'elbow': its limits are 3 to 2.5".
void check_description(const RobotDescription& robot);

} // namespace oncollide
