#pragma once
#include <oncollide/narrowphase/shapes/convex.hpp>

namespace oncollide {

/// The unit normal, outward, of a solid's surface where it is nearest to a point inside or near it; of an ellipsoid
/// that of the similar one through the point. 0 where that is not told: in the middle of a sphere, a capsule or an
/// ellipsoid. The solid has a volume. Cost: of a hull 2 ns a face.
Eigen::Vector3d outward_normal(const Convex& solid, const Eigen::Vector3d& point);

} // namespace oncollide
