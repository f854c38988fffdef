#pragma once
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/base/function_ref.hpp>

namespace oncollide {

/// The rotation given by a file's numbers x, y, z, w. Private to scenes. A length within 1e-12 of 1 is not normalised,
/// so that saved quaternions are read back bit for bit; others are normalised, with a line in `warnings` if the length
/// differs by more than 1e-6. Throws Error{bad_data} for a length outside [1e-6, 1e6] or not finite.
/// @param place  returns the position in the file, for messages; called only for a message
Eigen::Quaterniond quaternion_of(FunctionRef<std::string()> place, const Eigen::Vector4d& xyzw,
                                 std::vector<std::string>& warnings);

} // namespace oncollide
