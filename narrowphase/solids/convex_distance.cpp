#include <oncollide/narrowphase/solids/convex_distance.hpp>

#include <algorithm>

#include <oncollide/narrowphase/solids/simplex.hpp>

namespace oncollide {

ConvexDistance convex_distance(const ConvexDifference& cores, const EnoughDistance& enough,
                               const Eigen::Vector3d* first)
{
    constexpr int most_steps = 256; // smooth cores take 10 to 40
    const double rounding = cores.rounding();
    ConvexDistance found{std::max(cores.least(), 0.0), std::numeric_limits<double>::infinity(), {}, {}};
    Simplex4 simplex;
    Eigen::Vector3d v = first ? *first : cores.middle();
    if (v.isZero(0)) v = Eigen::Vector3d::UnitX();
    for (int step = 0; step < most_steps; ++step) {
        const double length = v.norm();
        if (!(length > 0)) break;
        const ConvexDifference::Point p = cores.support(-v);
        found.lower = std::max(found.lower, v.dot(p.w) / length - rounding);
        if (found.lower > enough.above || found.upper - found.lower <= enough.tolerance + 4 * rounding) break;
        if (simplex.holds(p.w)) break;
        simplex.corner[simplex.count++] = p;
        simplex.reduce();
        v = simplex.nearest();
        const double upper = v.norm() + rounding;
        if (!(upper < found.upper)) break;
        found.upper = upper, found.on_a = simplex.on_a(), found.on_b = found.on_a + v;
        if (upper <= enough.below || simplex.count == 4) break;
    }
    found.lower = std::min(found.lower, found.upper);
    return found;
}

} // namespace oncollide
