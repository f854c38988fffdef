#include <oncollide/narrowphase/shapes/least_translation.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Geometry>

#include <oncollide/narrowphase/shapes/box_axes.hpp>
#include <oncollide/narrowphase/shapes/expanding_polytope.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3d;

/// A gap between cores below this many roundings has no certain direction.
constexpr double least_gap = 0x1p12;

/// A core that is a point or a segment along z.
bool is_thin(const Convex& c)
{
    return c.core == Convex::Core::box && c.low.x() == c.high.x() && c.low.y() == c.high.y();
}

struct Ends {
    Vector3d on_a, on_b;
};

/// The nearest points of two segments or points.
Ends nearest_of_segments(const ConvexDifference& cores)
{
    const RelativePose& into = cores.b_to_a();
    const double ha = cores.a().high.z(), hb = cores.b().high.z();
    const Vector3d d = into.rotation.col(2), t = into.translation;
    const double c = d.z(), along_a = t.z(), along_b = d.dot(t), rest = 1 - c * c;
    double s = 0, u = 0; // from the middles
    if (rest > 0x1p-40) s = std::clamp((along_a - c * along_b) / rest, -ha, ha);
    u = std::clamp(c * s - along_b, -hb, hb);
    s = std::clamp(along_a + c * u, -ha, ha);
    u = std::clamp(c * s - along_b, -hb, hb);
    return {Vector3d(0, 0, s), t + u * d};
}

/// Bounds and normal of cores that are apart, from their nearest points.
bool set_apart(const ConvexDifference& cores, const Ends& ends, double rounding, LeastTranslation& found)
{
    const Vector3d v = ends.on_b - ends.on_a;
    const double gap = v.norm();
    if (!(gap > least_gap * rounding)) return false;
    found.normal = v / gap;
    // The gap along any direction is a lower bound of the distance.
    const double along = found.normal.dot(cores.support(-found.normal).w);
    found.upper = rounding - along, found.lower = -gap - rounding;
    found.normal_error = std::min(std::numbers::pi, 2 * std::sqrt(2 * std::max(found.upper - found.lower, 0.0) / gap));
    found.on_a = ends.on_a, found.on_b = ends.on_b, found.has_points = true;
    return along > 0;
}

/// By the distance; false: the cores meet, or nearly.
bool by_distance(const ConvexDifference& cores, double rounding, double cutoff, LeastTranslation& found)
{
    const double below = -std::numeric_limits<double>::infinity(), radius = cores.radius();
    const ConvexDistance d = convex_distance(cores, {.cutoff = cutoff + radius + rounding, .below = below});
    if (d.lower > cutoff + radius + rounding) {
        found.beyond = true, found.upper = -d.lower;
        return true;
    }
    if (!set_apart(cores, {d.on_a, d.on_b}, rounding, found)) return false;
    found.upper = std::min(found.upper, -d.lower);
    return true;
}

LeastTranslation of_cores(const ConvexDifference& cores, double rounding, double cutoff)
{
    const Convex &a = cores.a(), &b = cores.b();
    LeastTranslation found{};
    const bool thin_a = is_thin(a), thin_b = is_thin(b), boxes = a.core == Convex::Core::box && b.core == a.core;
    if (thin_a && thin_b) {
        if (set_apart(cores, nearest_of_segments(cores), rounding, found)) return found;
        return translation_of_boxes(cores, rounding, cutoff + cores.radius());
    }
    if (boxes && cores.radius() > 0) {
        const bool point_a = a.low == a.high, point_b = b.low == b.high;
        if (point_a || point_b) {
            const RelativePose& into = cores.b_to_a();
            Ends ends;
            if (point_b) {
                ends.on_b = into.translation, ends.on_a = ends.on_b.cwiseMax(a.low).cwiseMin(a.high);
            } else {
                const Vector3d p = cores.into_b(-into.translation);
                ends.on_a.setZero(), ends.on_b = into(p.cwiseMax(b.low).cwiseMin(b.high));
            }
            if (set_apart(cores, ends, rounding, found)) return found;
        } else if (by_distance(cores, rounding, cutoff, found)) {
            return found;
        }
        return translation_of_boxes(cores, rounding, cutoff + cores.radius());
    }
    if (cores.radius() > 0 && by_distance(cores, rounding, cutoff, found)) return found;
    found = boxes ? translation_of_boxes(cores, rounding, cutoff)
                  : translation_by_polytope(cores, rounding, cutoff + cores.radius());
    if (found.beyond || !(found.upper < 0) || cores.radius() > 0) return found;
    // Apart by a plane: the distance may be larger than the gap at the plane.
    LeastTranslation apart{};
    if (!by_distance(cores, rounding, cutoff, apart)) return found;
    if (apart.beyond) return apart;
    if (found.upper <= apart.upper + 8 * rounding) { // the plane's normal has less rounding in it
        apart.normal = found.normal, apart.normal_error = found.normal_error, apart.upper = found.upper;
        apart.lower = std::min(apart.lower, apart.upper);
    }
    return apart;
}

} // namespace

LeastTranslation least_translation(const ConvexDifference& cores, double cutoff)
{
    // A pose may stretch lengths by the slack.
    const double radius = cores.radius();
    const double rounding =
        cores.rounding() + cores.slack() * (cores.size() + radius + cores.b_to_a().translation.norm());
    LeastTranslation found = of_cores(cores, rounding, cutoff);
    found.lower += radius, found.upper += radius;
    if (found.beyond) return found;
    const double off = 0x1p-50 * radius;
    found.lower -= off, found.upper += off;
    found.beyond = found.upper < -cutoff;
    return found;
}

} // namespace oncollide
