// Truths in extended precision: shapes and convex parts at rest.
#include <algorithm>
#include <cmath>

#include "league/truths/solids.hpp"
#include "league/truths/truths.hpp"

namespace oncollide::tools::truths {
namespace {

using Eigen::Vector3d;
using oracle::LongVector;
using oracle::SolidGap;
using oracle::SolidTruth;
using Meet = LeagueTruth::Meet;

const LeagueBody* half_space_of(const LeagueCase& asked)
{
    for (const LeagueBody* body : {&asked.a, &asked.b})
        if (const auto* shape = std::get_if<Shape>(&body->geometry); shape && std::holds_alternative<HalfSpace>(*shape))
            return body;
    return nullptr;
}

} // namespace

LeagueTruth shapes_apart(const LeagueCase& asked)
{
    LeagueTruth truth{.size = asked.a.size() + asked.b.size()};
    for (const LeagueBody* body : {&asked.a, &asked.b})
        truth.coordinate = std::max(truth.coordinate, body->pose.translation().cwiseAbs().maxCoeff() + body->size());
    const auto solids = solids_of(asked);
    SolidGap least{.lower = std::numeric_limits<long double>::infinity(),
                   .upper = std::numeric_limits<long double>::infinity()};
    for (const SolidTruth& a : solids->a)
        for (const SolidTruth& b : solids->b)
            if (const SolidGap gap = gap_of(a, b); gap.upper < least.upper) least = gap;
    truth.lower = least.lower, truth.upper = least.upper;
    truth.gap = least.lower;
    const long double rounding = 1e-15L * truth.size + 1e-18L * truth.coordinate;
    truth.meet = least.lower > rounding ? Meet::no : least.upper <= rounding ? Meet::yes : Meet::open;
    const LongVector up = asked.a.pose.linear().col(2).cast<long double>().normalized();
    if (truth.meet == Meet::yes && solids->simple()) {
        const oracle::LeastWidth width =
            least_width(solids->a[0], solids->b[0], gap_of(solids->a[0], solids->b[0]), up);
        truth.gap = -width.width;
    } else if (truth.meet == Meet::yes) {
        truth.gap = 0; // how deep is not known: touching and deep count alike
        truth.meet = Meet::open;
        for (const SolidTruth& a : solids->a) // deep in one part is deep
            for (const SolidTruth& b : solids->b)
                if (gap_of(a, b).upper <= rounding) {
                    const oracle::LeastWidth width = least_width(a, b, gap_of(a, b), up);
                    truth.gap = std::min(truth.gap, -width.width), truth.meet = Meet::yes;
                }
    }
    if (asked.question == LEAGUE_DISTANCE && std::holds_alternative<Shape>(asked.a.geometry))
        truth.off_surface = [solids](const Vector3d& point, int of) {
            const SolidTruth& solid = of ? solids->b[0] : solids->a[0];
            return std::abs(solid.from_surface((point.cast<long double>() - solids->origin.cast<long double>())));
        };
    return truth;
}

bool gap_confirmed(const LeagueCase& asked, const LeagueTruth& truth)
{
    if (asked.a.solid) return true; // its inside is no set of triangles
    const LeagueBody* ground = half_space_of(asked);
    const TrueDistance distance =
        ground ? half_space_distance(ground->pose, sets_of(ground == &asked.a ? asked.b : asked.a))
               : true_distance(sets_of(asked.a), sets_of(asked.b));
    // The truth takes a half-space's normal for a unit vector, which it is not if it was rounded to float.
    const long double stretch = ground ? std::abs(ground->pose.linear().col(2).norm() - 1) : 0;
    const long double rounding =
        1e-12L * truth.size + 1e-15L * truth.coordinate + 4 * stretch * (truth.size + distance.upper);
    const long double lower = truth.meet == Meet::no ? std::max(truth.gap, 0.0L) : 0;
    return distance.upper >= lower - rounding && (truth.meet == Meet::no || distance.lower <= rounding);
}

LeagueTruth shapes_deep(const LeagueCase& asked)
{
    LeagueTruth truth = shapes_apart(asked);
    truth.lower = 0, truth.upper = std::max(-truth.gap, 0.0L);
    if (truth.meet != Meet::yes || !(truth.gap < 0)) return truth;
    truth.lower = truth.upper = -truth.gap;
    const auto solids = solids_of(asked);
    const SolidTruth &a = solids->a[0], &b = solids->b[0];
    const bool known = a.is_half_space() || b.is_half_space() || (a.has_flat_core() && b.has_flat_core());
    if (!known) truth.lower = 0; // the least width that was found is an upper bound
    truth.way_out = [solids, least = truth.upper](const Vector3d& along) {
        const SolidTruth &a = solids->a[0], &b = solids->b[0];
        const LongVector unit = along.cast<long double>();
        long double apart = width_along(a, b, unit), meet = 0;
        if (apart <= least * (1 + 1e-9L)) return apart;
        // They may be apart before a plane across the direction separates them.
        for (int k = 0; k < 50; ++k) {
            const long double way = (meet + apart) / 2;
            (gap_of(a, b, way * unit).upper > 0 ? apart : meet) = way;
        }
        return apart;
    };
    return truth;
}

} // namespace oncollide::tools::truths
