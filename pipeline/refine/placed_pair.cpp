#include <oncollide/pipeline/refine/placed_pair.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace oncollide {

double stretch(const Eigen::Isometry3d& pose)
{
    const Eigen::Vector3d x = pose.linear().col(0), y = pose.linear().col(1), z = pose.linear().col(2);
    const double lengths = std::max({std::abs(x.dot(x) - 1), std::abs(y.dot(y) - 1), std::abs(z.dot(z) - 1)});
    const double angles = std::max({std::abs(x.dot(y)), std::abs(y.dot(z)), std::abs(z.dot(x))});
    if (lengths == 0 && angles == 0 && (pose.linear().array().square() == pose.linear().array().abs()).all()) return 0;
    return 3 * std::max(lengths, angles) + 0x1p-50;
}

PlacedPair::PlacedPair(const Eigen::Isometry3d& pose_a, const Eigen::Isometry3d& pose_b)
    : b_to_a(pose_a, pose_b), slack(stretch(pose_a) + stretch(pose_b))
{
}

bool without_walk(const Model& a, const Model& b)
{
    return (a.shape() && b.shape()) || a.is_half_space() || b.is_half_space();
}

DirectPair::DirectPair(const PairTask& task)
    : task_(task), swapped_(!task.a->is_half_space() && task.b->is_half_space()),
      placed_(swapped_ ? *task.pose_b : *task.pose_a, swapped_ ? *task.pose_a : *task.pose_b)
{
}

ConvexMeeting DirectPair::meeting() const
{
    Model& second = swapped_ ? *task_.a : *task_.b;
    if (swapped_ || task_.a->is_half_space()) return HalfSpacePair(second, placed_.b_to_a, placed_.slack).meeting();
    return ConvexPair(task_.a->convex(), second.convex(), placed_.b_to_a, placed_.slack).meeting();
}

ConvexDistance DirectPair::placed_distance(const EnoughDistance& enough) const
{
    Model& second = swapped_ ? *task_.a : *task_.b;
    if (swapped_ || task_.a->is_half_space())
        return HalfSpacePair(second, placed_.b_to_a, placed_.slack).distance(enough.above);
    return ConvexPair(task_.a->convex(), second.convex(), placed_.b_to_a, placed_.slack).distance(enough);
}

Finding DirectPair::exact(double clearance) const
{
    const ConvexMeeting m = meeting();
    if (m.sign < 0) return {Verdict::colliding, ContactKind::unknown, 0};
    if (m.sign == 0) return {Verdict::within, ContactKind::unknown, placed_.above(m.bound)};
    if (clearance > 0) return by_distance(clearance);
    return {Verdict::separate, ContactKind::unknown, placed_.below(m.bound)};
}

Finding DirectPair::by_distance(double clearance) const
{
    return compare(clearance, {}, ContactKind::near);
}

Finding DirectPair::near(double clearance, double tolerance) const
{
    return compare(clearance, {.below = clearance + tolerance}, ContactKind::unknown);
}

Finding DirectPair::compare(double clearance, EnoughDistance enough, ContactKind kind) const
{
    enough.above = placed_.above(placed_.above(clearance));
    const ConvexDistance d = placed_distance(enough);
    if (const double lower = placed_.below(d.lower); lower > clearance)
        return {Verdict::separate, ContactKind::unknown, lower};
    return {Verdict::within, kind, placed_.above(d.upper) + 0x1p-1000};
}

Distance DirectPair::distance(const EnoughDistance& enough) const
{
    const ConvexDistance d = placed_distance(enough);
    const Eigen::Isometry3d& frame = swapped_ ? *task_.pose_b : *task_.pose_a;
    const double lower = placed_.below(d.lower);
    Distance found{.lower = lower,
                   .upper = lower > enough.above ? std::numeric_limits<double>::infinity() : placed_.above(d.upper),
                   .point_a = frame * d.on_a,
                   .point_b = frame * d.on_b};
    if (swapped_) std::swap(found.point_a, found.point_b);
    return found;
}

} // namespace oncollide
