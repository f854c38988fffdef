#pragma once
#include <algorithm>
#include <optional>

#include <oncollide/narrowphase/shapes/convex_distance.hpp>
#include <oncollide/narrowphase/shapes/convex_meeting.hpp>
#include <oncollide/narrowphase/shapes/least_translation.hpp>

namespace oncollide {

/// Two solid convex bodies at a relative pose.
class ConvexPair {
public:
    /// Keeps references.
    /// @param slack  relative error of lengths between the frames of world, A and B; 0 if there is none
    ConvexPair(const Convex& a, const Convex& b, const RelativePose& b_to_a, double slack);

    /// Decides whether they meet. The sign is exact for B as placed, and never 0, for two polytopes and, if the slack
    /// is 0, for spheres swept over polytopes. Otherwise it is certain except for rounding, 2^-47 of their sizes and
    /// distance, and the slack.
    ConvexMeeting meeting() const;

    /// Bounds of the distance, both 0 if they certainly meet. The points are on the bodies and, within rounding,
    /// `upper` apart; if the bodies meet, both are one common point. If goal.below is -infinity, swept spheres that
    /// meet return their point of deepest overlap.
    ConvexDistance distance(DistanceGoal goal) const;

    /// A lower bound of the length of a translation that parts them, metres. Known for two boxes; otherwise 0.
    double depth() const { return axes_ ? std::max(axes_->lower, 0.0) : 0; }

private:
    ConvexMeeting meeting_of_balls() const;
    ConvexMeeting meeting_of_cores() const;
    ConvexDistance distance_of_cores(const DistanceGoal& goal) const;
    bool nearest_of_boxes(const DistanceGoal& goal, ConvexDistance& found) const;
    bool distance_of_point_and_box(ConvexDistance& found) const;

    const Convex &a_, &b_;
    const RelativePose& b_to_a_;
    const double radius_; ///< sum of both radii
    const bool exact_;    ///< true: exact tests can decide cases that rounding hides
    const ConvexDifference cores_;
    const std::optional<LeastTranslation> axes_; ///< of two boxes: separating axes decide first
};

} // namespace oncollide
