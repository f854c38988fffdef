#include <oncollide/narrowphase/shapes/convex_pair.hpp>

#include <algorithm>
#include <limits>

#include <oncollide/narrowphase/shapes/box_axes.hpp>
#include <oncollide/narrowphase/shapes/exact_cores.hpp>
#include <oncollide/narrowphase/shapes/newton_meeting.hpp>

namespace oncollide {

namespace {

/// The axis of least overlap of two boxes.
std::optional<LeastTranslation> axes_of(const ConvexDifference& cores)
{
    if (!are_boxes(cores)) return {};
    return least_translation(cores, std::numeric_limits<double>::infinity(), false);
}

} // namespace

ConvexPair::ConvexPair(const Convex& a, const Convex& b, const RelativePose& b_to_a, double slack)
    : a_(a), b_(b), b_to_a_(b_to_a), radius_(a.radius + b.radius),
      exact_(a.flat_sided && b.flat_sided && (radius_ == 0 || slack == 0)), cores_(a, b, b_to_a, slack),
      axes_(axes_of(cores_))
{
}

ConvexMeeting ConvexPair::meeting() const
{
    if (axes_ && axes_->upper < 0) return {1, -axes_->upper};
    if (axes_ && axes_->lower > 0) return {-1, 0};
    const ConvexMeeting found = radius_ > 0 ? meeting_of_balls() : meeting_of_cores();
    if (found.sign != 0 || !exact_) return found;
    const double gap = exact_gap(a_, b_, b_to_a_);
    return gap > 0 ? ConvexMeeting{1, gap} : ConvexMeeting{-1, 0};
}

ConvexMeeting ConvexPair::meeting_of_balls() const
{
    const DistanceGoal goal{.cutoff = radius_, .below = radius_};
    ConvexDistance d;
    if (a_.core == Convex::Core::ellipsoid || b_.core == Convex::Core::ellipsoid) {
        const NewtonMeeting looks = newton_meeting(cores_);
        if (looks.meeting.sign != 0) return looks.meeting;
        d = convex_distance(cores_, goal, &looks.direction);
    } else {
        d = distance_of_cores(goal);
    }
    if (d.lower > radius_) return {1, d.lower - radius_};
    if (d.upper <= radius_) return {-1, 0};
    return {0, d.upper - radius_};
}

ConvexMeeting ConvexPair::meeting_of_cores() const
{
    const ConvexMeeting found = convex_meeting(cores_);
    if (found.sign != 0) return found;
    const ConvexDistance d = convex_distance(cores_, {.cutoff = 0});
    if (d.lower > 0) return {1, d.lower};
    return {0, std::min(found.bound, d.upper)};
}

/// The nearest points of two boxes, if they lie along the axis of the largest gap: then the gap is the distance. False:
/// they do not, or the axis does not part the boxes.
bool ConvexPair::nearest_of_boxes(const DistanceGoal& goal, ConvexDistance& found) const
{
    if (!axes_ || !(axes_->upper < 0)) return false;
    const Eigen::Vector3d& n = axes_->normal;
    const ConvexDifference::Point p = cores_.support(-n);
    found.on_a = p.a, found.on_b = p.a + p.w;
    if (axes_->has_points) { // of two edges
        found.on_a = axes_->on_a, found.on_b = axes_->on_b;
    } else if (n.cwiseAbs().maxCoeff() == 1) { // a face of A
        found.on_a = found.on_b.cwiseMax(a_.low).cwiseMin(a_.high);
    } else {
        const Eigen::Vector3d in_b = cores_.into_b(found.on_a - b_to_a_.translation);
        found.on_b = b_to_a_(in_b.cwiseMax(b_.low).cwiseMin(b_.high));
    }
    const double rounding = cores_.rounding();
    found.lower = -axes_->upper, found.upper = (found.on_b - found.on_a).norm() + rounding, found.toward = n;
    return found.lower > goal.cutoff || found.upper <= goal.below ||
           found.upper - found.lower <= goal.tolerance + 16 * rounding;
}

/// The centre of a sphere and the core of a box, a sphere or a capsule, in closed form. False: the cores are others.
bool ConvexPair::distance_of_point_and_box(ConvexDistance& found) const
{
    if (!nearest_of_point_and_box(cores_, found.on_a, found.on_b, found.toward)) return false;
    double off = cores_.rounding();
    // A point moved into B's frame errs by as much again, and by the rotation's deviation from rigid.
    if (b_.low != b_.high) off = 2 * off + 2 * cores_.slack() * (cores_.size() + cores_.radius());
    const double length = found.toward.norm();
    found.lower = std::max(length - off, 0.0), found.upper = length + off;
    return true;
}

ConvexDistance ConvexPair::distance_of_cores(const DistanceGoal& goal) const
{
    ConvexDistance d;
    if (distance_of_point_and_box(d) || nearest_of_boxes(goal, d)) return d;
    return convex_distance(cores_, goal, axes_ && axes_->upper < 0 ? &axes_->normal : nullptr);
}

ConvexDistance ConvexPair::distance(DistanceGoal goal) const
{
    goal.cutoff += radius_, goal.below += radius_;
    ConvexDistance d = distance_of_cores(goal);
    // The direction between bodies that almost touch is lost in rounding. A portal's direction is not lost; and where
    // the meeting is certain, the distance must agree with it.
    if (radius_ == 0 ? d.lower < 0x1p-20 * d.upper : d.lower <= radius_ && d.upper > radius_) {
        const ConvexMeeting m = meeting();
        if (m.sign > 0) d.lower = std::min(std::max(d.lower, radius_ + m.bound), d.upper);
        if (m.sign < 0) d.lower = std::min(d.lower, radius_), d.upper = std::min(d.upper, radius_);
    }
    // Move the points from the cores to the surfaces of the swept spheres, or to the middle of the spheres' overlap.
    const Eigen::Vector3d v = d.on_b - d.on_a;
    const double length = v.norm();
    if (length > radius_)
        d.on_a += a_.radius / length * v, d.on_b -= b_.radius / length * v;
    else if (radius_ > 0 && length > 0)
        d.on_a += (std::max(length - b_.radius, 0.0) + std::min(a_.radius, length)) / (2 * length) * v, d.on_b = d.on_a;
    d.lower = std::max(d.lower - radius_, 0.0), d.upper = std::max(d.upper - radius_, 0.0);
    return d;
}

} // namespace oncollide
