#pragma once
#include <Eigen/Core>

namespace oncollide {

/// True when the triangle is a segment or a point: a, b and c lie on one line, decided exactly (as long as the
/// coordinates of one triangle span fewer than 400 powers of two). Private to scenes.
bool has_zero_area(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

} // namespace oncollide
