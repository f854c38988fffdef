#pragma once
#include <oncollide/narrowphase/shapes/convex.hpp>

namespace oncollide {

/// The outward unit normal of a solid's surface where it is nearest to a point inside or near the solid; for an
/// ellipsoid, the normal of the similar ellipsoid through the point. 0 where it is undefined: in the middle of a
/// sphere, a capsule or an ellipsoid. The solid must have a volume. Cost: 2 ns per face for a hull.
Eigen::Vector3d outward_normal(const Convex& solid, const Eigen::Vector3d& point);

} // namespace oncollide
