#pragma once
#include <string>
#include <vector>

#include <Eigen/Geometry>

namespace oncollide::tools {

/// The numbers in an option's text, separated by spaces or commas. Throws Error{usage} unless there are `count`,
/// all finite; the message shows `form`, e.g. "x y z".
std::vector<double> parse_numbers(const std::string& option, const std::string& text, std::size_t count,
                                  const char* form);
/// Throws the error of parse_numbers, for numbers that the caller finds invalid.
[[noreturn]] void refuse_numbers(const std::string& option, const std::string& text, const std::string& why,
                                 const char* form);

/// Reads the option's text "x y z qx qy qz qw" as a pose, with the quaternion normalised. Empty text is the identity.
/// Throws as parse_numbers, and for a quaternion without a direction.
/// @param length  out: of the quaternion
Eigen::Isometry3d parse_pose(const std::string& option, const std::string& text, double& length);

} // namespace oncollide::tools
