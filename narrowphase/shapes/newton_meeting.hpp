#pragma once
#include <oncollide/narrowphase/shapes/convex_meeting.hpp>

namespace oncollide {

/// What a few looks along directions, each chosen by what the last one showed, told of two solids.
struct NewtonMeeting {
    ConvexMeeting meeting;               ///< sign 0: left open, and the bound says nothing
    ConvexDifference::Point first, last; ///< found by the first look and, if there were more, by the last
    Eigen::Vector3d direction;           ///< of the last look or of one after it
    int looks;
};

/// Decides in one to four looks whether most solids meet whose surfaces are curved; where faces or edges touch, it
/// mostly gives up after the second look. Polytopes get one look. Cost: 40 to 80 ns a look.
///
/// The gap along a direction is a concave function of it where bodies are apart, whose derivatives are those of the
/// support functions, which are known. Newton's method finds the direction along which it is largest; a gap along any
/// is a certificate. The certificate of a contact is a farthest point of one body that is inside the other.
NewtonMeeting newton_meeting(const ConvexDifference& cores);

/// Towards the direction along which the gap is largest, by Newton's method, at right angles to the last one.
/// @param n  the last one, of length 1
/// @param w  what it showed: the support point along -n
Eigen::Vector3d newton_step(const ConvexDifference& cores, const Eigen::Vector3d& n, const Eigen::Vector3d& w);

} // namespace oncollide
