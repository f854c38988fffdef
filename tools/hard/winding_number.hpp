#pragma once
#include <span>

#include <Eigen/Core>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide::tools {

/// How often a closed surface winds around a point that is not on it: 0 outside, 1 inside, -1 if it is inside out. By
/// solid angles, in long double: a point 2^-60 of the surface's size off it is still on its side.
/// Source: van Oosterom and Strackee, "The solid angle of a plane triangle", IEEE Trans. Biomed. Eng. 1983.
long double winding_number(std::span<const Eigen::Vector3d> vertices, std::span<const Triangle> triangles,
                           const Eigen::Vector3d& point);

} // namespace oncollide::tools
