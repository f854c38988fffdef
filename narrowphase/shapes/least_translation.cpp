#include <oncollide/narrowphase/shapes/least_translation.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Geometry>

#include <oncollide/narrowphase/shapes/box_axes.hpp>
#include <oncollide/narrowphase/shapes/expanding_polytope.hpp>
#include <oncollide/narrowphase/shapes/newton_meeting.hpp>
#include <oncollide/narrowphase/shapes/triangle_axes.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3d;

/// A gap between cores below this many roundings has no certain direction.
constexpr double least_gap = 0x1p12;
constexpr int most_polish_steps = 6;
/// Share of a gap. Bounds that are as close give the direction to 2^-7.
constexpr double close_enough = 0x1p-16;
/// Share of the depth. An interval that is wider is improved.
constexpr double loose = 0x1p-7;

struct Ends {
    Vector3d on_a, on_b;
    Vector3d toward = Vector3d::Zero(); ///< another direction to try; 0: none
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

/// Bounds and normal of cores that are apart, from their nearest points. False: they are too near for a certain
/// direction; the points are of the cores, and the bounds hold, if `upper` is below 0.
bool set_apart(const ConvexDifference& cores, const Ends& ends, double rounding, LeastTranslation& found)
{
    Vector3d on_a = ends.on_a, v = ends.on_b - ends.on_a;
    double gap = v.norm();
    const bool certain = gap > least_gap * rounding;
    found.lower = -gap - rounding, found.upper = std::numeric_limits<double>::infinity();
    found.on_a = on_a, found.on_b = ends.on_b, found.off = gap, found.has_points = true; // the gap may be none
    if (!(gap > rounding)) return false;
    // The gap along any direction is a lower bound of the distance.
    Vector3d n = v / gap;
    ConvexDifference::Point p = cores.support(-n);
    double along = n.dot(p.w);
    if (!ends.toward.isZero(0) && ends.toward != v) {
        const Vector3d other = ends.toward.normalized();
        if (const ConvexDifference::Point q = cores.support(-other); other.dot(q.w) > along)
            n = other, p = q, along = n.dot(q.w);
    }
    if (!cores.flat_sided()) // the distance of curved cores was found to about the root of the rounding
        for (int step = 0; step < most_polish_steps && gap - along > 2 * rounding; ++step) {
            if (const double length = p.w.norm(); length < gap) gap = length, on_a = p.a, v = p.w;
            const Vector3d next = (n + newton_step(cores, n, p.w)).normalized();
            const ConvexDifference::Point q = cores.support(-next);
            if (!(next.dot(q.w) > along)) break;
            n = next, p = q, along = n.dot(q.w);
        }
    if (!(along > 0)) return false;
    found.normal = n, found.upper = rounding - along, found.lower = -gap - rounding;
    found.normal_error = angle_to_shortest(along - rounding, gap + rounding);
    found.on_a = on_a, found.on_b = on_a + v, found.off = std::max(gap - along, 0.0), found.has_points = true;
    return certain;
}

/// By the distance; false: the cores meet, or nearly. @param toward  a direction from A to B to try first; null: none
bool by_distance(const ConvexDifference& cores, double rounding, double cutoff, LeastTranslation& found,
                 const Vector3d* toward = nullptr)
{
    DistanceGoal goal{.cutoff = cutoff + cores.radius() + rounding, .below = -std::numeric_limits<double>::infinity()};
    const auto find = [&](const Vector3d* first) {
        const ConvexDistance d = convex_distance(cores, goal, first);
        found.beyond = d.lower > goal.cutoff;
        if (!found.beyond) return set_apart(cores, {d.on_a, d.on_b, d.toward}, rounding, found);
        found.upper = -d.lower;
        return true;
    };
    if (cores.flat_sided() || cores.radius() > 0) return find(nullptr);
    goal.share = 0x1p-6; // Newton's method finds the rest, in most cases
    if (!find(toward)) return false;
    const bool decided = found.beyond || -found.lower <= 0.25 * cutoff; // a margin may be a little less
    if (decided && found.upper - found.lower <= close_enough * -found.lower) return true;
    goal.share = 0;
    const Vector3d first = found.normal;
    return find(&first);
}

/// Improves the normal and the points of curved cores that overlap little. The shortest way between the cores, after B
/// has moved out a little, has nearly this direction.
void improve_shallow(const ConvexDifference& cores, double rounding, LeastTranslation& found)
{
    const double smaller = std::min(cores.a().extent, cores.b().extent);
    for (double way = 0x1p-4 * smaller; way > 0x1p-16 * smaller; way *= 0x1p-4) {
        RelativePose moved = cores.b_to_a();
        const Vector3d out = (std::max(found.upper, 0.0) + way) * found.normal;
        moved.translation += out;
        const ConvexDifference parted(cores.a(), cores.b(), moved, cores.slack());
        LeastTranslation apart{};
        if (!by_distance(parted, rounding, std::numeric_limits<double>::infinity(), apart)) return;
        const ConvexDifference::Point p = cores.support(-apart.normal);
        if (const double width = -apart.normal.dot(p.w) + rounding; width < found.upper) {
            found.normal = apart.normal, found.upper = width, found.lower = std::min(found.lower, width);
            found.offer(p.a, p.a + p.w, 0);
        }
        found.offer(apart.on_a, apart.on_b - out, apart.off + rounding);
    }
}

LeastTranslation of_cores(const ConvexDifference& cores, double rounding, double cutoff)
{
    const Convex &a = cores.a(), &b = cores.b();
    LeastTranslation found{};
    const bool thin_a = is_thin(a), thin_b = is_thin(b), boxes = a.core == Convex::Core::box && b.core == a.core;
    // Box cores that are nearly in contact. Their distance may be larger than the gap along the best axis.
    const auto by_axes = [&] {
        LeastTranslation axes = translation_of_boxes(cores, rounding, cutoff + cores.radius());
        if (axes.beyond || axes.lower > 0) return axes;
        if (found.upper < axes.upper) return found;
        axes.lower = std::min(axes.lower, found.lower);
        return axes;
    };
    if (thin_a && thin_b) {
        const Ends ends = nearest_of_segments(cores);
        if (set_apart(cores, ends, rounding, found)) return found;
        found = by_axes();
        found.on_a = ends.on_a, found.on_b = ends.on_b, found.has_points = true;
        return found;
    }
    if (boxes && cores.radius() > 0) {
        if (Ends ends; nearest_of_point_and_box(cores, ends.on_a, ends.on_b, ends.toward)) {
            if (set_apart(cores, ends, rounding, found)) return found;
        } else if (by_distance(cores, rounding, cutoff, found)) {
            return found;
        }
        return by_axes();
    }
    LeastTranslation apart{};
    const bool swept = cores.radius() > 0;
    bool certain = swept && by_distance(cores, rounding, cutoff, apart);
    if (certain && (apart.beyond || apart.upper - apart.lower <= loose * std::abs(cores.radius() + apart.upper)))
        return apart; // the distance of needles ends early; a plane may part the cores better
    // Most triangles around a round shape are apart from it, which the distance finds sooner.
    if (is_triangle(a) && !swept && !cores.flat_sided() && by_distance(cores, rounding, cutoff, apart)) return apart;
    const bool axes = boxes || are_triangle_and_box(cores);
    found = boxes  ? translation_of_boxes(cores, rounding, cutoff)
            : axes ? translation_of_triangle_and_box(cores, rounding, cutoff)
                   : translation_by_polytope(cores, rounding, cutoff + cores.radius());
    if (!certain && !found.beyond && found.upper - found.lower > loose * std::abs(found.upper) + 16 * rounding)
        improve_shallow(cores, rounding, found);
    if (!certain && apart.has_points && !apart.beyond) // points of both, where they overlap by a rounding
        found.offer(apart.on_a, apart.on_b, std::max(found.upper, 0.0) + apart.off + rounding);
    // Apart by a plane: the distance may be larger than the gap at the plane.
    if (found.beyond || !(found.upper < 0 || found.lower < -hidden_gap * rounding)) return found;
    if (!swept) certain = by_distance(cores, rounding, cutoff, apart, &found.normal);
    if (apart.beyond) return apart;
    const double lower = axes ? apart.lower : std::max(found.lower, apart.lower); // axes bound the gap at a plane
    if (certain && found.upper <= apart.upper + 8 * rounding) // the plane's normal has less rounding in it
        apart.normal = found.normal, apart.upper = found.upper;
    if (certain || apart.upper < found.upper) found = apart;
    found.lower = std::min(lower, found.upper);
    found.normal_error = angle_to_shortest(-found.upper, -found.lower);
    return found;
}

/// A pose may stretch lengths by the slack.
double rounding_of(const ConvexDifference& cores)
{
    return cores.rounding() + cores.slack() * (cores.size() + cores.radius() + cores.b_to_a().translation.norm());
}

LeastTranslation with_radius(LeastTranslation found, double radius, double cutoff)
{
    const double off = 0x1p-50 * radius;
    found.lower += radius - off, found.upper += radius + off;
    found.beyond |= found.upper < -cutoff;
    if (!found.beyond && found.upper < 0 && found.lower > -std::numeric_limits<double>::infinity())
        found.normal_error =
            std::max(found.normal_error, angle_to_shortest(radius - found.upper, radius - found.lower));
    return found;
}

} // namespace

double angle_to_shortest(double along, double way)
{
    const double cosine = along / way;
    return cosine > 0 ? std::min(std::numbers::pi, std::sqrt(2 * std::max(1 - cosine, 0.0)) * 1.6 + 0x1p-50)
                      : std::numbers::pi;
}

LeastTranslation least_translation(const ConvexDifference& cores, double cutoff, bool gap_of_boxes)
{
    if (gap_of_boxes || !are_boxes(cores))
        return with_radius(of_cores(cores, rounding_of(cores), cutoff), cores.radius(), cutoff);
    LeastTranslation found = translation_of_boxes(cores, rounding_of(cores), cutoff);
    // A gap that edges show, beside a face that is preferred, has the edges' direction.
    if (!found.beyond && (found.upper < 0 || found.lower < -hidden_gap * cores.rounding()))
        found.lower = -std::numeric_limits<double>::infinity();
    return found;
}

void improve_points(const ConvexDifference& cores, LeastTranslation& found)
{
    const double radius = cores.radius(), rounding = rounding_of(cores);
    const double smaller = std::min(cores.a().extent + cores.a().radius, cores.b().extent + cores.b().radius);
    if (found.upper <= radius) return; // the cores are apart, so these are their nearest points
    found.upper -= radius;
    double way = 0x1p-4 * smaller;
    for (int k = 0; k < 4 && found.points_error() > 0x1p-20 * smaller + 16 * rounding; ++k, way *= 0x1p-6) {
        RelativePose moved = cores.b_to_a();
        const Vector3d out = (std::max(found.upper, 0.0) + way) * found.normal;
        moved.translation += out;
        const ConvexDistance apart =
            convex_distance(ConvexDifference(cores.a(), cores.b(), moved, cores.slack()), {}, &found.normal);
        found.offer(apart.on_a, apart.on_b - out, apart.upper - apart.lower + rounding);
    }
    found.upper += radius;
}

LeastTranslation deepest_translation(const ConvexDifference& cores)
{
    const double endless = std::numeric_limits<double>::infinity();
    return with_radius(translation_by_polytope(cores, rounding_of(cores), endless), cores.radius(), endless);
}

} // namespace oncollide
