#pragma once
#include <oncollide/narrowphase/shapes/least_translation.hpp>

namespace oncollide {

/// The least translation of two cores that are boxes, segments or points, by separating axes; without their radii.
/// Edges that are parallel to 1e-8 have no axis of their own, which costs `lower` as much of the sizes.
LeastTranslation translation_of_boxes(const ConvexDifference& cores, double rounding, double cutoff);

/// How far two boxes without a radius overlap along the separating axis where they overlap least, in metres, rounding
/// included: at least `lower`, at most `upper`, which is below 0 if they are apart.
struct BoxOverlap {
    double lower, upper;
};
BoxOverlap overlap_of_boxes(const Convex& a, const Convex& b, const RelativePose& b_to_a, double rounding);

/// A core that is a point or a segment along z.
inline bool is_thin(const Convex& c)
{
    return c.core == Convex::Core::box && c.low.x() == c.high.x() && c.low.y() == c.high.y();
}

/// True if both are boxes without a radius.
inline bool are_boxes(const ConvexDifference& cores)
{
    return cores.a().core == Convex::Core::box && cores.b().core == Convex::Core::box && cores.radius() == 0;
}

/// The nearest points of two such cores, of which one is a point, in A's frame. False: the cores are others.
/// @param toward  set to the direction from A to B, across the box's edges up to a rounding of its own length
bool nearest_of_point_and_box(const ConvexDifference& cores, Eigen::Vector3d& on_a, Eigen::Vector3d& on_b,
                              Eigen::Vector3d& toward);

} // namespace oncollide
