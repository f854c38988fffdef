#include <oncollide/narrowphase/pairs/closed_forms.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include <oncollide/base/numbers/infinity.hpp>
#include <oncollide/narrowphase/model.hpp>
#include <oncollide/narrowphase/pairs/placed_pair.hpp>
#include <oncollide/narrowphase/shapes/box_axes.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3d;

constexpr double most_slack = 0x1p-17; ///< poses may be 2^-20 from rigid
constexpr double underflow = 0x1p-500; ///< metres: squares of less are 0

/// A point around which a sphere is swept: the core has no extent.
bool is_ball(const Convex& c)
{
    return c.core == Convex::Core::box && c.extent == 0;
}

bool has_closed_form(const Convex& c)
{
    return c.core != Convex::Core::points && c.core != Convex::Core::ellipsoid;
}

/// The distance of a point, in the solid's frame, from its core, which has a closed form.
double distance_from_core(const Convex& c, const Vector3d& p)
{
    if (c.core == Convex::Core::box) {
        double sum = 0;
        for (int i = 0; i < 3; ++i) {
            const double beyond = std::max(std::max(c.low[i] - p[i], p[i] - c.high[i]), 0.0);
            sum += beyond * beyond;
        }
        return std::sqrt(sum);
    }
    const double across = std::sqrt(p.x() * p.x() + p.y() * p.y()), radius = c.high.x(), half = c.high.z();
    const auto length = [](double x, double y) { return std::sqrt(x * x + y * y); };
    const double beyond = std::max(across - radius, 0.0);
    if (c.core == Convex::Core::cylinder) return length(beyond, std::max(std::abs(p.z()) - half, 0.0));
    // A cone's nearest point is on its base or on its slant line, which starts at the base's rim.
    const double out = across - radius, up = p.z() + half, slope = length(radius, 2 * half);
    const double off = (2 * half * out + radius * up) / slope; // from the slant line, outwards
    if (off <= 0 && up >= 0) return 0;
    const double along = std::clamp((2 * half * up - radius * out) / slope, 0.0, slope);
    const double share = along / slope, from_slant = length(out + share * radius, up - share * 2 * half);
    return std::min(from_slant, length(beyond, up));
}

Vector3d in_frame(const Eigen::Isometry3d& pose, const Vector3d& v)
{
    const double* const r = pose.data(); // columns of four
    const auto along = [&](int i) { return r[4 * i] * v.x() + r[4 * i + 1] * v.y() + r[4 * i + 2] * v.z(); };
    return {along(0), along(1), along(2)};
}

std::optional<Finding> separate(double apart, double slack, double clearance)
{
    apart *= 1 - slack;
    if (apart > clearance || clearance == 0) return Finding{Verdict::separate, ContactKind::unknown, apart};
    return {};
}

/// Heights over the half-space z <= 0 of A, with the operations of RelativePose.
struct Heights {
    Vector3d up;    ///< in B's frame
    double origin;  ///< height of B's origin
    double way = 0; ///< at least the distance of the two origins

    Heights(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b)
    {
        const double* const z = a.data() + 8;
        const double* const of_b = b.data();
        const auto along = [&](double x, double y, double w) { return z[0] * x + z[1] * y + z[2] * w; };
        for (int j = 0; j < 3; ++j) up[j] = along(of_b[4 * j], of_b[4 * j + 1], of_b[4 * j + 2]);
        const Vector3d between = b.translation() - a.translation();
        origin = along(between.x(), between.y(), between.z());
        if (a.linear() == b.linear()) up = Vector3d::UnitZ();
        way = between.lpNorm<1>() * (1 + 0x1p-18);
    }
    double of(const Vector3d& p) const { return up.x() * p.x() + (up.y() * p.y() + up.z() * p.z()) + origin; }
};

/// The height of the core's lowest point.
double lowest(const Convex& c, const Heights& heights)
{
    const Vector3d& up = heights.up;
    const auto across = [&] { return c.high.x() * std::sqrt(up.x() * up.x() + up.y() * up.y()); };
    switch (c.core) {
    case Convex::Core::box:
        // The lowest corner minimises every product, rounding included: sums of larger products are not less.
        return heights.of(c.support(-up));
    case Convex::Core::points: {
        double least = infinity;
        for (const Vector3d& p : std::span(c.points, c.count)) least = std::min(least, heights.of(p));
        return least;
    }
    case Convex::Core::cylinder:
        return heights.origin - (std::abs(up.z()) * c.high.z() + across());
    case Convex::Core::cone:
        return heights.origin + std::min(up.z() * c.high.z(), -up.z() * c.high.z() - across());
    case Convex::Core::ellipsoid:
        return heights.origin - c.high.cwiseProduct(up).norm();
    }
    __builtin_unreachable();
}

} // namespace

std::optional<Finding> decide_by_centre(const PairTask& task, double clearance)
{
    const Convex &a = task.a->convex(), &b = task.b->convex();
    const bool of_a = is_ball(a), both = of_a && is_ball(b);
    if (!of_a && !is_ball(b)) return {};
    const Convex& other = of_a ? b : a;
    if (!has_closed_form(other)) return {};
    const Eigen::Isometry3d &ball_pose = of_a ? *task.pose_a : *task.pose_b, &pose = of_a ? *task.pose_b : *task.pose_a;
    const Vector3d way = ball_pose.translation() - pose.translation();
    const double apart = both ? way.norm() : distance_from_core(other, in_frame(pose, way));
    // With u = 2^-53: the way errs by u of its length, its rotation by 6 u, the distance by 9 u of the sizes. The slack
    // covers the rotation's inverse, the frame's lengths and the radii.
    const double radius = a.radius + b.radius, size = way.lpNorm<1>() + other.extent + radius;
    if (apart + (0x1p-47 + 2 * most_slack) * size + underflow <= radius)
        return Finding{Verdict::colliding, ContactKind::unknown, 0};
    const double slack = slack_of(task), off = (0x1p-47 + 2 * slack) * size + underflow;
    if (apart + off <= radius) return Finding{Verdict::colliding, ContactKind::unknown, 0};
    if (apart - off > radius) return separate(apart - off - radius, slack, clearance);
    return {};
}

std::optional<Finding> decide_by_height(const PairTask& task, bool swapped, double clearance)
{
    const Convex& c = (swapped ? task.a : task.b)->convex();
    const Heights heights(swapped ? *task.pose_b : *task.pose_a, swapped ? *task.pose_a : *task.pose_b);
    const double height = lowest(c, heights);
    const auto doubt_at = [&](double slack) {
        return c.flat_sided ? slack * c.radius : (slack + 0x1p-47) * c.extent + 0x1p-47 * heights.way + underflow;
    };
    if (height <= c.radius - doubt_at(most_slack)) return Finding{Verdict::colliding, ContactKind::unknown, 0};
    const double slack = slack_of(task), doubt = doubt_at(slack);
    if (height <= c.radius - doubt) return Finding{Verdict::colliding, ContactKind::unknown, 0};
    if (height > c.radius + doubt) return separate((height - c.radius - doubt) * (1 - 0x1p-50), slack, clearance);
    return {};
}

std::optional<Finding> decide_by_axes(const PairTask& given, double clearance, double& depth)
{
    const PairTask task = decides_b_first(given) ? given.swapped() : given; // both orders give one bound
    const Convex &a = task.a->convex(), &b = task.b->convex();
    if (a.core != Convex::Core::box || b.core != Convex::Core::box || a.radius + b.radius > 0) return {};
    const RelativePose b_to_a(*task.pose_a, *task.pose_b);
    // As in ConvexDifference: all errors together are below 2^-47 of the sizes and the way, besides the slack.
    const double size = a.extent + b.extent + b_to_a.translation.lpNorm<1>(), slack = slack_of(task);
    const double rounding = (0x1p-47 + slack) * size + 0x1p-1000;
    const BoxOverlap overlap = overlap_of_boxes(a, b, b_to_a, rounding);
    if (overlap.lower > 0) {
        depth = overlap.lower * (1 - slack);
        return Finding{Verdict::colliding, ContactKind::unknown, 0};
    }
    if (overlap.upper < 0) return separate(-overlap.upper, slack, clearance);
    return {};
}

} // namespace oncollide
