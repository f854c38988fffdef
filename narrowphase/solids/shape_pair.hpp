#pragma once
#include <oncollide/narrowphase/model.hpp>
#include <oncollide/narrowphase/solids/convex_distance.hpp>
#include <oncollide/narrowphase/solids/convex_meeting.hpp>

namespace oncollide {

/// Two shapes at a relative pose, both solid; no trees. The models must be shapes.
class ShapePair {
public:
    /// Keeps references.
    /// @param slack  by how much a length of 1 may differ between the frames of world, A and B; 0 where none does
    ShapePair(const Model& a, const Model& b, const RelativePose& b_to_a, double slack);

    /// Do they meet? Boxes and hulls, and where the slack is 0 spheres and capsules with each other and with these,
    /// exactly for B as placed: then the sign is never 0. Others but for rounding, 2^-47 of their sizes and distance,
    /// and the slack.
    ConvexMeeting meeting() const;

    /// Bounds on the distance of the shapes; the points are on them, and `upper` apart, but for rounding.
    ConvexDistance distance(EnoughDistance enough) const;

private:
    ConvexMeeting meeting_of_balls() const;
    ConvexMeeting meeting_of_cores() const;

    const Model &a_, &b_;
    const RelativePose& b_to_a_;
    const Convex &of_a_, &of_b_;
    const double radius_; ///< of both together
    const bool exact_;    ///< can exact tests decide what rounding hides?
    const ConvexDifference cores_;
};

} // namespace oncollide
