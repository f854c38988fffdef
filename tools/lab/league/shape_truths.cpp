// Truths in extended precision: shapes, and convex parts.
#include <algorithm>
#include <cmath>
#include <memory>

#include "league/truths.hpp"
#include "truth/convex_truth.hpp"
#include "verify/oracle/solid_gap.hpp"

namespace oncollide::tools::truths {
namespace {

using Eigen::Vector3d;
using oracle::LongVector;
using oracle::SolidGap;
using oracle::SolidTruth;
using Meet = LeagueTruth::Meet;

/// The convex parts whose union a body is, relative to `origin`.
/// @param faces  triangles have them, which finds their least widths
std::vector<SolidTruth> parts_of(const LeagueBody& body, const Vector3d& origin, bool faces = false)
{
    std::vector<SolidTruth> parts;
    const auto add = [&](const std::vector<Vector3d>& points) { parts.emplace_back(points, body.pose, origin); };
    if (const auto* shape = std::get_if<Shape>(&body.geometry)) parts.emplace_back(*shape, body.pose, origin);
    if (const auto* map = std::get_if<OccupancyMap>(&body.geometry))
        map->each_box([&](const Aabb& box) {
            const auto corners = corners_of(box);
            add({corners.begin(), corners.end()});
        });
    const auto triangles = [&](const Mesh& mesh) {
        for (const auto& [i, j, k] : mesh.triangles) {
            const std::vector<Vector3d> corners{mesh.vertices[i], mesh.vertices[j], mesh.vertices[k]};
            if (faces)
                parts.emplace_back(Shape(ConvexHull{corners}), body.pose, origin);
            else
                add(corners);
        }
    };
    if (const auto* terrain = std::get_if<Terrain>(&body.geometry)) triangles(mesh_of(*terrain));
    if (const auto* mesh = std::get_if<Mesh>(&body.geometry)) {
        if (body.solid)
            add(mesh->vertices); // these meshes are convex
        else
            triangles(*mesh);
    }
    return parts;
}

struct Solids {
    Vector3d origin;
    std::vector<SolidTruth> a, b;

    bool simple() const { return a.size() == 1 && b.size() == 1; }
};

std::shared_ptr<const Solids> solids_of(const LeagueCase& asked)
{
    const Vector3d origin = asked.b.pose.translation();
    return std::make_shared<const Solids>(Solids{origin, parts_of(asked.a, origin), parts_of(asked.b, origin)});
}

const LeagueBody* half_space_of(const LeagueCase& asked)
{
    for (const LeagueBody* body : {&asked.a, &asked.b})
        if (const auto* shape = std::get_if<Shape>(&body->geometry); shape && std::holds_alternative<HalfSpace>(*shape))
            return body;
    return nullptr;
}

std::vector<ConvexSet> sets_of(const LeagueBody& body)
{
    return convex_sets(body.geometry, body.pose);
}

/// The shape b moves toward a convex part of a. They meet where their gap is below rounding.
class Approach {
public:
    Approach(const LeagueCase& asked, const SolidTruth& a)
        : asked_(asked), a_(a), b_(moved(0)), motion_(asked.motion.cast<long double>()),
          size_(asked.a.size() + asked.b.size()), rounding_(1e-15L * (size_ + motion_.norm()))
    {
    }

    /// Finds the time of the first contact, its bounds, or the least gap.
    LeagueTruth contact() const
    {
        LeagueTruth truth;
        if (gap(0) == 0) {
            truth.meet = Meet::yes, truth.lower = truth.upper = 0;
            truth.gap = -size_; // a cast that begins in contact must not be lost
            return truth;
        }
        long double low = 0, high = 1;
        for (int k = 0; k < 200 && gap(high) > 0 && high - low > 1e-12L; ++k) {
            const long double p = low + 0.382L * (high - low), q = high - 0.382L * (high - low);
            const long double at_p = gap(p), at_q = gap(q);
            if (at_p == 0) {
                high = p;
            } else if (at_q == 0) {
                high = q;
            } else if (at_p < at_q) {
                high = q;
            } else {
                low = p;
            }
        }
        if (gap(high) > 0) {
            truth.gap = std::min(gap(high), gap(low));
            truth.meet = truth.gap > 1e-9L * size_ ? Meet::no : Meet::open;
            truth.lower = low, truth.upper = high;
            return truth;
        }
        const long double met = high;
        for (low = 0; high - low > 1e-16L;) {
            const long double middle = (low + high) / 2;
            if (middle <= low || middle >= high) break;
            (gap(middle) > 0 ? low : high) = middle;
        }
        truth.lower = low, truth.upper = high;
        const auto surely = [&](long double t) { return gap_of(a_, b_, t * motion_).upper <= 4 * rounding_; };
        if (!surely(high)) truth.upper = met; // a sliver, whose gap is known less well
        truth.meet = surely(truth.upper) ? Meet::yes : Meet::open;
        return truth;
    }

    /// How deep b is in a at most, from the first contact on, by golden sections: the depth is a concave function of
    /// time until they part, and then 0.
    long double greatest_depth(long double from) const
    {
        long double to = 1, most = depth(1);
        for (int k = 0; k < 40; ++k) {
            const long double p = from + 0.382L * (to - from), q = to - 0.382L * (to - from);
            const long double at_p = depth(p), at_q = depth(q);
            most = std::max({most, at_p, at_q});
            if (at_p >= at_q)
                to = q;
            else
                from = p;
        }
        return most;
    }

private:
    SolidTruth moved(double t) const
    {
        Eigen::Isometry3d pose = asked_.b.pose;
        pose.translation() += t * asked_.motion;
        return SolidTruth(std::get<Shape>(asked_.b.geometry), pose, a_.origin());
    }
    long double gap(long double t) const
    {
        const SolidGap found = gap_of(a_, b_, t * motion_);
        return found.lower > rounding_ ? found.lower : 0;
    }
    /// Negative: they are apart.
    long double depth(long double t) const
    {
        const SolidTruth b = moved(double(t));
        const SolidGap found = gap_of(a_, b);
        return found.upper > rounding_ ? -found.upper : least_width(a_, b, found, LongVector::UnitZ()).width;
    }

    const LeagueCase& asked_;
    const SolidTruth& a_;
    SolidTruth b_;
    LongVector motion_;
    long double size_, rounding_;
};

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
    const long double rounding =
        1e-12L * truth.size + 1e-15L * truth.coordinate + (ground ? 1e-6L * distance.upper : 0);
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
    truth.way_out = [solids](const Vector3d& unit) {
        return width_along(solids->a[0], solids->b[0], unit.cast<long double>());
    };
    return truth;
}

LeagueTruth first_contact(const LeagueCase& asked)
{
    LeagueTruth truth{.way = asked.motion.cast<long double>().norm(), .size = asked.a.size() + asked.b.size()};
    truth.coordinate =
        std::max({asked.a.pose.translation().cwiseAbs().maxCoeff(), asked.b.pose.translation().cwiseAbs().maxCoeff(),
                  asked.motion.cwiseAbs().maxCoeff()}) +
        truth.size;
    const std::vector<SolidTruth> parts = parts_of(asked.a, asked.a.pose.translation(), true);
    long double least = std::numeric_limits<long double>::infinity(), maybe = least;
    truth.meet = Meet::no;
    for (const SolidTruth& part : parts) {
        const Approach approach(asked, part);
        const LeagueTruth found = approach.contact();
        if (found.meet != Meet::yes) {
            least = std::min(least, found.gap);
            if (found.meet == Meet::open) maybe = std::min(maybe, found.lower);
            continue;
        }
        truth.lower = truth.meet == Meet::yes ? std::min(truth.lower, found.lower) : found.lower;
        truth.upper = std::min(truth.upper, found.upper), truth.meet = Meet::yes;
        // How deep they get later: rounding may lose a graze.
        const long double deep = found.gap < 0 ? -found.gap : approach.greatest_depth(found.upper);
        truth.gap = std::min(truth.gap, -deep);
    }
    if (truth.meet == Meet::yes) {
        truth.lower = std::min(truth.lower, maybe); // rounding decides whether another part was met before
    } else {
        truth.gap = least;
        if (std::isfinite(maybe)) truth.meet = Meet::open;
    }
    return truth;
}

bool contact_confirmed(const LeagueCase& asked, const LeagueTruth& truth)
{
    if (truth.meet == Meet::open) return true;
    const auto apart_at = [&](long double t) {
        LeagueBody moved = asked.b;
        moved.pose.translation() += double(t) * asked.motion;
        return true_distance(sets_of(asked.a), sets_of(moved));
    };
    const long double rounding = 1e-9L * truth.size + 1e-14L * truth.coordinate;
    if (truth.meet == Meet::no) {
        for (int k = 0; k <= 16; ++k)
            if (apart_at(k / 16.0L).upper <= 0) return false;
        return true;
    }
    return apart_at(truth.upper).lower <= rounding && (truth.lower == 0 || apart_at(truth.lower / 2).upper > 0);
}

} // namespace oncollide::tools::truths
