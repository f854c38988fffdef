// When two convex parts first meet, where they nearly touch, touch, or overlap a little.
#pragma once
#include <algorithm>
#include <limits>
#include <utility>

#include <oncollide/narrowphase/walks/swept_motion.hpp>

namespace oncollide {

/// As first_entry(), for parts whose nearest points are so close that rounding would turn the line between them. The
/// parts are lifted off each other in several directions, which gives the line exactly. An overlap counts as a gap if
/// the slack is negative.
/// @param scales  sizes of the smaller and the larger part, metres
/// @param between  between(time, lift): a vector from A's nearest point to B's, after the linear motion until then and
/// with B moved by `lift`
PartsEntry careful_entry(const SweptParts& parts, double from, double until, Eigen::Vector3d& line,
                         std::pair<double, double> scales, auto apart, auto between)
{
    using Eigen::Vector3d;
    constexpr int most_tries = 16, refinements = 3;
    constexpr double enough = 0x1p-12; // times, as shares of the window
    const double small = scales.first, large = scales.second;
    const double least_lift = 4 * std::max(0.0, -parts.slack), lift = std::max(0x1p-4 * small, least_lift);
    PartsEntry found{from, from, Vector3d::Zero()};
    Vector3d best = line;
    double most = -std::numeric_limits<double>::infinity(), before = from;
    const auto take = [&](const Vector3d& direction) {
        const double gap = apart(direction), there = gap + before * direction.dot(parts.speed);
        const PartsEntry entry = entry_along(direction, gap, parts, found.time);
        if (entry.time > found.time || (there > most && entry.time == found.time)) found = entry;
        if (there > most) most = there, best = direction;
        return found.time < until;
    };
    const auto take_between = [&](const Vector3d& lifted) {
        const Vector3d nearest = between(before, lifted);
        const double length = nearest.norm();
        return !(length > 0) || take(nearest / (length * (1 + 0x1p-50)));
    };
    const auto try_all = [&] {
        const double length = between(before, Vector3d::Zero()).norm();
        if (!take_between(Vector3d::Zero())) return false;
        if (length > std::max(0x1p-6 * small, 0x1p-22 * large)) return true;
        if (!best.isZero(0) && !take_between(lift * Vector3d(best))) return false;
        for (int axis = 0; axis < 3; ++axis)
            for (const double side : {1, -1}) {
                const Vector3d along = side * Vector3d::Unit(axis);
                if (!take(along) || !take_between(lift * along)) return false; // the axes of boxes and cells are exact
            }
        // Far above a large face, the line to it is exact to its other end.
        for (int k = 0; large > 2 * small && k < 2; ++k)
            if (!take_between(large * Vector3d(best))) return false;
        double by = lift;
        for (int k = 0; k < refinements; ++k, by = std::max(0x1p-3 * by, least_lift))
            if (!take_between(by * Vector3d(best))) return false;
        return true;
    };
    if (!line.isZero(0) && !take(line)) return {};
    for (int step = 0; step < most_tries; ++step) {
        before = found.time, most = -std::numeric_limits<double>::infinity();
        if (!try_all()) {
            line = best;
            return {};
        }
        if (found.time - before < enough) break;
    }
    return found;
}

} // namespace oncollide
