#pragma once
#include <span>
#include <string>

#include "robot/robot_world.hpp"

namespace oncollide::tools {

/// Throws if no pair would be tested, because the robot must not be reported free then.
void check_pairs(const RobotOptions& options, bool no_self, const RobotDescription& robot, std::size_t bodies);

/// Prints a note that names the links that nothing can collide with.
void tell_links_without_geometry(const RobotDescription& robot);

enum class LimitsCheck { ignore, warn, refuse };
/// The value of --limits. Throws Error{usage}.
LimitsCheck limits_check(const std::string& text);
/// Throws for the first configuration that is out of the limits of a joint, or warns of all such configurations.
void check_limits(LimitsCheck check, const Robot& robot, std::span<const double> numbers, bool quiet);

} // namespace oncollide::tools
