#pragma once
#include <limits>

#include <oncollide/narrowphase/shapes/convex_difference.hpp>

namespace oncollide {

/// When bounds on a distance are good enough: the lower one is above `above`, the upper one at most `below`, or the two
/// are no farther apart than `tolerance`.
struct EnoughDistance {
    double above = std::numeric_limits<double>::infinity();
    double below = 0, tolerance = 0;
};

/// Certified bounds on the distance of two cores, rounding included. Metres.
struct ConvexDistance {
    double lower, upper;        ///< 0 <= lower <= upper; where they meet, the upper one is about rounding
    Eigen::Vector3d on_a, on_b; ///< points of the cores, but for rounding, that are `upper` apart; in A's frame
};

/// Stops at the first bounds that are enough, else where doubles come no nearer: bounds that are further apart than
/// rounding are those of cores that are all but in contact, see convex_meeting.hpp.
/// Cost: 0.1 to 0.4 microseconds for boxes and hulls of few points.
/// Source: Gilbert, Johnson and Keerthi, "A fast procedure for computing the distance between complex objects in
/// three-dimensional space", 1988; a lower bound from each direction in which it looks.
/// @param first  the direction from A to B in which it looks first; null: that of their middles
ConvexDistance convex_distance(const ConvexDifference& cores, const EnoughDistance& enough,
                               const Eigen::Vector3d* first = nullptr);

} // namespace oncollide
