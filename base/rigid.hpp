#pragma once
#include <string>

#include <Eigen/Geometry>

namespace oncollide {

/// Returns why `pose` is not a rigid motion, or an empty text: entries that are not finite, a linear part R whose R^T R
/// differs from the identity by more than 1e-6, or a reflection.
std::string why_not_rigid(const Eigen::Isometry3d& pose);

} // namespace oncollide
