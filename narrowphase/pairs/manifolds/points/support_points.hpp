#pragma once
#include <vector>

#include <oncollide/narrowphase/shapes/convex.hpp>

namespace oncollide {

/// The support point of a round solid along a direction (unit, frame of the solid), and other points of its surface on
/// which the solid may lie: ends of a line, corners of a disc.
std::vector<Eigen::Vector3d> support_points(const Convex& solid, const Eigen::Vector3d& direction);

} // namespace oncollide
