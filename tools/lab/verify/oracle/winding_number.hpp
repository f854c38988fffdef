#pragma once
#include <span>

#include <Eigen/Core>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide::tools {

/// Winding number of a closed surface around a point that is not on it: 0 outside, 1 inside, -1 if it is inside out. By
/// solid angles, in long double: correct for points at least 2^-60 of the surface's size away from it.
/// Source: van Oosterom and Strackee, "The solid angle of a plane triangle", IEEE Trans. Biomed. Eng. 1983.
long double winding_number(std::span<const Eigen::Vector3d> vertices, std::span<const Triangle> triangles,
                           const Eigen::Vector3d& point);

} // namespace oncollide::tools
