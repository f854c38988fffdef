// Linear motion of two bodies over a window of time, and the time at which two convex parts first meet. Times run from
// -1 to 1 and are 0 in the middle of the window, where the parts are at the pair's relative pose; all is in A's frame
// there.
#pragma once
#include <algorithm>

#include <Eigen/Geometry>

namespace oncollide {

/// A point at x moves by shift + turn x x for each unit of time.
struct SweptSide {
    Eigen::Vector3d shift = Eigen::Vector3d::Zero(), turn = Eigen::Vector3d::Zero();
    [[gnu::always_inline]] Eigen::Vector3d at(const Eigen::Vector3d& x) const { return shift + turn.cross(x); }
};

/// How a window treats parts that nearly touch.
struct NearTouch {
    bool careful = false; ///< look for directions that are exact there (careful_entry.hpp); slower
    double depth = 0;     ///< metres, only if careful: parts that overlap by no more do not count as meeting
};

/// The points of a ball with centre c and radius r stay within |turn| r of the motion of c. Together, both bodies stay
/// within `slack` more of these motions; the slack includes the clearance.
struct SweptMotion {
    SweptSide a, b;
    double slack = 0;
    NearTouch touch{};
};

/// The motion of a part of B relative to a part of A: by `speed` for each unit of time, up to `slack`.
struct SweptParts {
    Eigen::Vector3d speed;
    double slack;
};

constexpr double after_window = 2; ///< a time after the window

/// When two parts first meet.
struct PartsEntry {
    double time = after_window;         ///< lower bound
    double likely = after_window;       ///< estimate without the slack, if `time` is in the window
    Eigen::Vector3d direction{0, 0, 0}; ///< unit, or 0: separates the parts until `time`, from A to B
};

/// A lower bound of the time, at least `from`, at which two parts meet that are `apart` from each other along a unit
/// direction at time 0.
inline PartsEntry entry_along(const Eigen::Vector3d& direction, double apart, const SweptParts& parts, double from)
{
    const double speed = direction.dot(parts.speed), gap = apart + from * speed - parts.slack;
    const bool close = gap <= 0;
    if (close && speed >= 0) return {from, after_window, direction};
    if (speed >= 0) return {};
    const double likely = std::max(from, apart / -speed);
    const double time = close ? from : std::max(from, from + gap / -speed * (1 - 0x1p-40) - 0x1p-50);
    return time > 1 ? PartsEntry{} : PartsEntry{time, likely, direction};
}

/// The time at which two convex parts first meet, from `from` on; after_window, if it is after `until`. Each step moves
/// the parts to the bound found so far, and separates them along the line of their nearest points there.
/// @param line  a unit direction to try first, or 0; set to one that shows that they do not meet
/// @param apart  apart(direction): a lower bound, rounding included, of how far apart the parts are along a unit
/// direction at time 0 @param between  between(time): a vector from A's nearest point to B's, within rounding, after
/// the linear motion until then
PartsEntry first_entry(const SweptParts& parts, double from, double until, Eigen::Vector3d& line, auto apart,
                       auto between)
{
    constexpr int most_tries = 16;
    constexpr double enough = 0x1p-12; // times, as shares of the window
    PartsEntry found{from, from, Eigen::Vector3d::Zero()};
    const auto take = [&](const Eigen::Vector3d& direction) {
        const PartsEntry entry = entry_along(direction, apart(direction), parts, found.time);
        if (entry.time > found.time || found.direction.isZero(0)) found = entry;
        return found.time < until;
    };
    if (!line.isZero(0) && !take(line)) return {};
    for (int step = 0; step < most_tries; ++step) {
        const double before = found.time;
        const Eigen::Vector3d nearest = between(before);
        const double length = nearest.norm();
        if (!(length > 0)) break;
        const Eigen::Vector3d direction = nearest / (length * (1 + 0x1p-50));
        if (!take(direction)) {
            line = direction;
            return {};
        }
        if (found.time - before < enough) break;
    }
    return found;
}

} // namespace oncollide
