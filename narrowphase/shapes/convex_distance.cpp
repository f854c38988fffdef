#include <oncollide/narrowphase/shapes/convex_distance.hpp>

#include <algorithm>

#include <oncollide/narrowphase/shapes/newton_meeting.hpp>
#include <oncollide/narrowphase/shapes/simplex.hpp>

namespace oncollide {

namespace {

constexpr int most_newton_steps = 8; ///< Newton's method takes four to six

/// True if one of them is an ellipsoid or a point. If both have edges or rims, Newton's method soon gets stuck, and its
/// evaluations are wasted.
bool one_is_smooth(const ConvexDifference& cores)
{
    const auto smooth = [](const Convex& c) { return c.core == Convex::Core::ellipsoid || !(c.extent > 0); };
    return smooth(cores.a()) || smooth(cores.b());
}

/// Newton's method, for curved cores: it finds the direction for smooth cores in a few evaluations. Returns whether the
/// bounds are then good enough; sets `v` to the best direction.
bool look_along_normals(const ConvexDifference& cores, const DistanceGoal& goal, Eigen::Vector3d& v,
                        ConvexDistance& found)
{
    const double rounding = cores.rounding();
    Eigen::Vector3d n = v.normalized();
    double last = -std::numeric_limits<double>::infinity();
    for (int look = 0; look < most_newton_steps; ++look) {
        const ConvexDifference::Point p = cores.support(-n);
        const double apart = n.dot(p.w), upper = p.w.norm() + rounding;
        if (!(apart > last)) break; // faces, edges, or the limit of doubles stop the progress
        last = apart, v = n;
        if (apart - rounding > found.lower) found.lower = apart - rounding, found.toward = n;
        if (upper < found.upper) found.upper = upper, found.on_a = p.a, found.on_b = p.a + p.w;
        if (goal.is_met(found.lower, found.upper, rounding)) return true;
        n = (n + newton_step(cores, n, p.w)).normalized();
    }
    return false;
}

} // namespace

ConvexDistance convex_distance(const ConvexDifference& cores, const DistanceGoal& goal, const Eigen::Vector3d* first)
{
    constexpr int most_steps = 256; // smooth cores take 10 to 40
    const double rounding = cores.rounding();
    ConvexDistance found{std::max(cores.least(), 0.0), std::numeric_limits<double>::infinity(), {}, {}};
    double nearest = std::numeric_limits<double>::infinity(); ///< distance of the simplex from 0
    // A new point may change the direction and not, within rounding, the distance; of a curved core, the next point may
    // then be much nearer.
    int stalls = cores.flat_sided() ? 2 : 8; ///< steps without progress that are left
    Simplex4 simplex;
    Eigen::Vector3d v = first ? *first : cores.middle();
    if (v.isZero(0)) v = Eigen::Vector3d::UnitX();
    if (!first && !cores.flat_sided() && one_is_smooth(cores) && look_along_normals(cores, goal, v, found)) {
        found.lower = std::min(found.lower, found.upper);
        return found;
    }
    double length = v.norm();
    const auto look = [&](const Eigen::Vector3d& along, double its_length) {
        const ConvexDifference::Point p = cores.support(-along);
        if (const double apart = along.dot(p.w) / its_length - rounding; apart > found.lower)
            found.lower = apart, found.toward = along;
        return p;
    };
    for (int step = 0; step < most_steps && length > 0; ++step) {
        const ConvexDifference::Point p = look(v, length);
        if (goal.is_met(found.lower, found.upper, rounding)) break;
        if (simplex.holds(p.w)) break;
        simplex.corner[simplex.count++] = p;
        simplex.reduce();
        v = simplex.nearest();
        length = v.norm();
        const double upper = length + rounding;
        if (!(upper < nearest) && stalls-- == 0) break;
        nearest = std::min(nearest, upper);
        if (upper < found.upper) found.upper = upper, found.on_a = simplex.on_a(), found.on_b = found.on_a + v;
        if (upper <= goal.below || simplex.count == 4) break;
    }
    if (length > 0 && !goal.is_met(found.lower, found.upper, rounding)) {
        // The nearest point has the rounding of the corners in it, which turns it where the distance is far smaller
        // than the corners' sizes.
        const Eigen::Vector3d across = simplex.across(v);
        if (const double size = across.norm(); size > 0) look(across, size);
    }
    found.lower = std::min(found.lower, found.upper);
    return found;
}

} // namespace oncollide
