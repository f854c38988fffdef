// Truths of contacts, for simulations.
#include <algorithm>
#include <cmath>

#include "league/truths/solids.hpp"
#include "league/truths/truths.hpp"

namespace oncollide::tools::truths {
namespace {

using Eigen::Vector3d;
using oracle::LongVector;
using oracle::SolidTruth;

/// How far a point is from the surface of the union of parts; 0 inside of a part that has no faces.
long double from_surface(const std::vector<SolidTruth>& parts, const LongVector& point)
{
    if (parts.size() == 1) return std::abs(parts[0].from_surface(point));
    long double least = std::numeric_limits<long double>::infinity();
    for (const SolidTruth& part : parts) least = std::min(least, gap_to(part, point).upper);
    return least;
}

} // namespace

LeagueTruth contacts(const LeagueCase& asked)
{
    const auto solids = solids_of(asked, true);
    LeagueTruth truth = solids->simple() ? shapes_deep(asked) : shapes_apart(asked);
    truth.lower = 0, truth.way_out = {};
    if (!solids->simple()) truth.upper = std::numeric_limits<long double>::infinity(); // of a union: not known
    truth.off_surface = [solids](const Vector3d& point, int of) {
        return from_surface(of ? solids->b : solids->a, point.cast<long double>() - solids->origin.cast<long double>());
    };
    if (!asked.footprint) return truth;
    const Footprint& foot = *asked.footprint;
    truth.lower = truth.upper = foot.depth, truth.gap = -foot.depth, truth.meet = LeagueTruth::Meet::yes;
    truth.tilt = [foot](const Vector3d& unit) {
        return std::atan2(foot.normal.cross(unit).norm(), foot.normal.dot(unit));
    };
    truth.off_middle = [foot](std::span<const Vector3d> positions) {
        std::vector<Vector3d> flat;
        for (const Vector3d& p : positions) flat.push_back(p - foot.normal * foot.normal.dot(p - foot.centre));
        return gap_to(SolidTruth(flat, Eigen::Isometry3d::Identity(), foot.centre), LongVector::Zero()).upper;
    };
    return truth;
}

bool contacts_confirmed(const LeagueCase& asked, const LeagueTruth& truth)
{
    LeagueTruth meeting = truth;
    meeting.gap = truth.meet == LeagueTruth::Meet::no ? truth.gap : 0;
    if (!gap_confirmed(asked, meeting)) return false;
    if (!asked.footprint) return true;
    // Along the normal, they are apart just after the depth, and meet just before it.
    const auto moved_by = [&](double way) {
        LeagueBody b = asked.b;
        b.pose.translation() += way * asked.footprint->normal;
        return true_distance(sets_of(asked.a), sets_of(b));
    };
    const double depth = asked.footprint->depth, rounding = double(1e-6L * truth.size + 1e-12L * truth.coordinate);
    return moved_by(depth + rounding).upper > 0 && moved_by(depth - rounding).lower <= 0;
}

} // namespace oncollide::tools::truths
