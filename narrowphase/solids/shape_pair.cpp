#include <oncollide/narrowphase/solids/shape_pair.hpp>

#include <algorithm>

#include <oncollide/narrowphase/solids/exact_cores.hpp>

namespace oncollide {

namespace {

/// The size of what the slack acts on: polytopes are what their vertices, as placed, are.
double round_size(const Convex& c)
{
    return c.radius + (c.flat_sided ? 0 : c.extent);
}

ConvexMeeting exactly(double gap)
{
    return gap > 0 ? ConvexMeeting{1, gap} : ConvexMeeting{-1, 0};
}

} // namespace

ShapePair::ShapePair(const Model& a, const Model& b, const RelativePose& b_to_a, double slack)
    : a_(a), b_(b), b_to_a_(b_to_a), of_a_(a.convex()), of_b_(b.convex()), radius_(of_a_.radius + of_b_.radius),
      exact_(of_a_.flat_sided && of_b_.flat_sided && (radius_ == 0 || slack == 0)),
      cores_(of_a_, of_b_, b_to_a, slack * (round_size(of_a_) + round_size(of_b_)) + 0x1p-50 * radius_)
{
}

ConvexMeeting ShapePair::meeting() const
{
    return radius_ > 0 ? meeting_of_balls() : meeting_of_cores();
}

ConvexMeeting ShapePair::meeting_of_balls() const
{
    const ConvexDistance d = convex_distance(cores_, {.above = radius_, .below = radius_});
    if (d.lower > radius_) return {1, d.lower - radius_};
    if (d.upper <= radius_) return {-1, 0};
    if (!exact_) return {0, d.upper - radius_};
    return exactly(gap_of_balls(a_.core().inner, b_.core().inner, b_to_a_, of_a_.radius, of_b_.radius));
}

ConvexMeeting ShapePair::meeting_of_cores() const
{
    ConvexMeeting found = convex_meeting(cores_);
    if (found.sign != 0) return found;
    const ConvexDistance d = convex_distance(cores_, {.above = 0});
    if (d.lower > 0) return {1, d.lower};
    if (!exact_) return {0, std::min(found.bound, d.upper)};
    return exactly(gap_of_polytopes(a_.core().inner, b_.core().inner, b_to_a_));
}

ConvexDistance ShapePair::distance(EnoughDistance enough) const
{
    enough.above += radius_, enough.below += radius_;
    ConvexDistance d = convex_distance(cores_, enough);
    // From the cores to the surfaces of the balls around them.
    const Eigen::Vector3d v = d.on_b - d.on_a;
    const double length = v.norm();
    if (length > radius_) d.on_a += of_a_.radius / length * v, d.on_b -= of_b_.radius / length * v;
    d.lower = std::max(d.lower - radius_, 0.0), d.upper = std::max(d.upper - radius_, 0.0);
    return d;
}

} // namespace oncollide
