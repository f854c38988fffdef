#pragma once
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/base/function_ref.hpp>

namespace oncollide {

/// The rotation that a file's four numbers x, y, z, w mean. Private to scenes. A length within 1e-12 of 1 is left
/// alone, so that what was written once is read back bit for bit; others are divided out, with a line in `warnings`
/// from 1e-6 on. Throws Error{bad_data} for a length outside [1e-6, 1e6] or not finite.
/// @param place  names the place in the file, for messages; called only when there is something to say
Eigen::Quaterniond quaternion_of(FunctionRef<std::string()> place, const Eigen::Vector4d& xyzw,
                                 std::vector<std::string>& warnings);

} // namespace oncollide
