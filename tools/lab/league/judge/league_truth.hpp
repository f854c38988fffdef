#pragma once
#include <functional>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "league/judge/league_case.hpp"

namespace oncollide::tools {

/// The right results to a case. Lengths in metres; times as fractions of the motion.
struct LeagueTruth {
    enum class Meet { no, yes, open }; ///< open: rounding decides, both results are right
    Meet meet = Meet::open;
    bool exact = false; ///< `meet` is right to the last bit, and so must results be
    /// Bounds of the distance; of depth: of the least translation that parts the two; of casts and rays: of the time.
    long double lower = 0, upper = std::numeric_limits<long double>::infinity();
    long double gap = 0;   ///< meet is not exact: how far apart the two are, negative: how deep they are in each other
    long double way = 0;   ///< of casts and rays: the length of the motion
    double size = 0;       ///< sum of the bodies' sizes, without half-spaces
    double coordinate = 0; ///< the largest coordinate
    /// How far a point is from the surface of a (0) or b (1); empty: not judged.
    std::function<long double(const Eigen::Vector3d& point, int of)> off_surface{};
    /// How far b must move along a unit vector until the two are parted; empty: not judged.
    std::function<long double(const Eigen::Vector3d& unit)> way_out{};
    /// The angle of a contact's normal, a unit vector, to the right one, radians; empty: not judged.
    std::function<double(const Eigen::Vector3d& unit)> tilt{};
    /// How far the hull of the contacts' positions leaves out the middle of the common area; empty: not judged.
    std::function<long double(std::span<const Eigen::Vector3d> positions)> off_middle{};
    /// How deep b is in a at most between two times of a cast; negative: how far apart they are at least. Empty: no
    /// result may be later than `upper`.
    std::function<long double(long double from, long double to)> deepest{};
    std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs{}; ///< a < b, sorted
};

/// The faults of a result, the gravest first.
/// extra: a conservative library may report that the bodies meet.
enum class LeagueFault : std::uint8_t {
    none,
    missed,
    late,
    invented,
    early,
    distance,
    depth,
    normal,
    points,
    support,
    extra
};
constexpr std::string_view fault_names[] = {"right", "missed", "late",   "invented", "early", "distance",
                                            "depth", "normal", "points", "support",  "extra"};

struct LeagueVerdict {
    LeagueFault fault = LeagueFault::none;
    double error = 0; ///< metres, or a share of the motion
    std::string expected{}, given{};
};

/// Judges a result.
/// @param rounding  of the library's numbers: 2^-53 or 2^-24; the coordinates have it, too
/// @param promised  by the library: its precision as a share of the bodies' sizes, and whether it is conservative
struct LeaguePromise {
    double precision = 0;
    bool conservative = false;
};
LeagueVerdict judge(league_question question, const LeagueTruth& truth, const league_answer& answer,
                    const LeaguePromise& promised, double rounding);

} // namespace oncollide::tools
