#pragma once
#include <oncollide/narrowphase/shapes/convex_distance.hpp>
#include <oncollide/narrowphase/shapes/convex_meeting.hpp>

namespace oncollide {

/// Two solid convex bodies at a relative pose.
class ConvexPair {
public:
    /// Keeps references.
    /// @param slack  by how much a length of 1 may differ between the frames of world, A and B; 0 where none does
    ConvexPair(const Convex& a, const Convex& b, const RelativePose& b_to_a, double slack);

    /// Do they meet? Two polytopes and, where the slack is 0, balls around polytopes exactly for B as placed: then the
    /// sign is never 0. Others but for rounding, 2^-47 of their sizes and distance, and the slack.
    ConvexMeeting meeting() const;

    /// Bounds on the distance, both 0 where they certainly meet; the points are on the bodies, and `upper` apart, but
    /// for rounding: one point of both where they meet. With enough.below infinitely low that of balls is where they
    /// overlap the most.
    ConvexDistance distance(EnoughDistance enough) const;

private:
    ConvexMeeting meeting_of_balls() const;
    ConvexMeeting meeting_of_cores() const;

    const Convex &a_, &b_;
    const RelativePose& b_to_a_;
    const double radius_; ///< of both together
    const bool exact_;    ///< can exact tests decide what rounding hides?
    const ConvexDifference cores_;
};

} // namespace oncollide
