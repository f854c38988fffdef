// Shapes that move until they meet others, and rays against meshes.
#include <algorithm>
#include <cmath>
#include <memory>

#include "league/families.hpp"
#include "truth/convex_truth.hpp"
#include "truth/exact_oracle.hpp"
#include "verify/cases/body_case.hpp"
#include "verify/cases/drawn_shapes.hpp"
#include "verify/oracle/segment_truth.hpp"
#include "verify/oracle/solid_gap.hpp"

#include <oncollide/samples/generators.hpp>

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;
using oracle::LongVector;
using oracle::SolidTruth;
using Meet = LeagueTruth::Meet;

/// The first contact of two convex solids of which b moves straight. The gap is a convex function of time: its least
/// value by golden sections, the first root before it by bisection.
LeagueTruth cast_truth(const LeagueCase& asked)
{
    LeagueTruth truth{.way = asked.motion.cast<long double>().norm(), .size = asked.a.size() + asked.b.size()};
    truth.coordinate =
        std::max({asked.a.pose.translation().cwiseAbs().maxCoeff(), asked.b.pose.translation().cwiseAbs().maxCoeff(),
                  asked.motion.cwiseAbs().maxCoeff()}) +
        truth.size;
    const Vector3d origin = asked.a.pose.translation();
    const SolidTruth a(std::get<Shape>(asked.a.geometry), asked.a.pose, origin),
        b(std::get<Shape>(asked.b.geometry), asked.b.pose, origin);
    const LongVector motion = asked.motion.cast<long double>();
    const long double rounding = 1e-15L * (truth.size + truth.way);
    const auto gap = [&](long double t) {
        const oracle::SolidGap found = gap_of(a, b, t * motion);
        return found.lower > rounding ? found.lower : 0;
    };
    if (gap(0) == 0) {
        truth.meet = Meet::yes, truth.lower = truth.upper = 0;
        truth.gap = -truth.size; // a cast that begins in contact must not be lost
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
        truth.meet = truth.gap > 1e-9L * truth.size ? Meet::no : Meet::open;
        return truth;
    }
    for (low = 0; high - low > 1e-16L;) {
        const long double middle = (low + high) / 2;
        if (middle <= low || middle >= high) break;
        (gap(middle) > 0 ? low : high) = middle;
    }
    truth.meet = Meet::yes, truth.lower = low, truth.upper = high;
    // How deep they get later: rounding may lose a graze.
    for (int k = 0; k <= 8; ++k) {
        Eigen::Isometry3d pose = asked.b.pose;
        pose.translation() += double(high + (1 - high) * k / 8) * asked.motion;
        const SolidTruth moved(std::get<Shape>(asked.b.geometry), pose, origin);
        if (const oracle::SolidGap at = gap_of(a, moved); at.upper <= rounding)
            truth.gap = std::min(truth.gap, -least_width(a, moved, at, LongVector::UnitZ()).width);
    }
    return truth;
}

/// By another GJK: apart shortly before the contact, and not far apart at it.
bool cast_confirmed(const LeagueCase& asked, const LeagueTruth& truth)
{
    if (truth.meet == Meet::open) return true;
    const auto apart_at = [&](long double t) {
        Eigen::Isometry3d pose = asked.b.pose;
        pose.translation() += double(t) * asked.motion;
        return true_distance(convex_sets(asked.a.geometry, asked.a.pose), convex_sets(asked.b.geometry, pose));
    };
    const long double rounding = 1e-9L * truth.size + 1e-14L * truth.coordinate;
    if (truth.meet == Meet::no) {
        for (int k = 0; k <= 16; ++k)
            if (apart_at(k / 16.0L).upper <= 0) return false;
        return true;
    }
    return apart_at(truth.upper).lower <= rounding && (truth.lower == 0 || apart_at(truth.lower / 2).upper > 0);
}

LeagueFamily cast_family(std::string name, std::string what,
                         std::function<LeagueCase(CaseNumbers&, std::uint64_t)> make)
{
    return {"cast: " + std::move(name),
            "motions",
            LEAGUE_CAST,
            std::move(what),
            [make](std::uint64_t seed) {
                CaseNumbers draw(seed);
                LeagueCase asked = make(draw, seed);
                asked.question = LEAGUE_CAST;
                return asked;
            },
            cast_truth,
            cast_confirmed};
}

Shape plate(double size, double thickness)
{
    return Box{{size, size, thickness}};
}

/// Two shapes of different kinds, the second moved away by `apart`, and aimed at a point near the first.
LeagueCase aimed(CaseNumbers& draw, std::uint64_t seed, double apart, double aside)
{
    constexpr int kinds = 7; // without half-spaces
    const ShapePair pair = draw_shape_pair(ShapeKind(seed % kinds), ShapeKind(seed / kinds % kinds), 12 * seed + 1);
    LeagueCase asked{.a = {pair.a, pair.pose_a}, .b = {pair.b, pair.pose_b}};
    const double size = asked.a.size() + asked.b.size();
    const Vector3d way = draw.vector().normalized();
    asked.b.pose.translation() = pair.pose_a.translation() - apart * size * way;
    asked.motion = 2 * apart * size * way + aside * size * draw.vector();
    return asked;
}

/// Vertices are on a grid of 2^-10, so that rays through them are exact in float, too.
Mesh gridded(Mesh mesh)
{
    for (Vector3d& v : mesh.vertices) v = v.unaryExpr([](double x) { return std::round(x * 1024) / 1024; });
    return make_mesh("mesh", std::move(mesh.vertices), std::move(mesh.triangles));
}

LeagueTruth ray_truth(const LeagueCase& asked)
{
    const auto& mesh = std::get<Mesh>(asked.a.geometry);
    LeagueTruth truth{.way = asked.motion.cast<long double>().norm(), .size = asked.a.size()};
    truth.exact = true;
    truth.coordinate = std::max(mesh.bounds.max.cwiseAbs().maxCoeff(),
                                asked.from.cwiseAbs().maxCoeff() + asked.motion.cwiseAbs().maxCoeff());
    const Segment segment{asked.from, asked.from + asked.motion};
    Aabb around;
    around.add(segment.from), around.add(segment.to);
    const auto truth_of = [&](double most) {
        oracle::SegmentTruth found;
        const Segment part{segment.from, segment.from + most * asked.motion};
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            const TrianglePoints corners = corners_of(mesh, t);
            Aabb box;
            for (const Vector3d& p : corners) box.add(p);
            if ((box.min.array() <= around.max.array()).all() && (box.max.array() >= around.min.array()).all())
                found.add(part, corners);
        }
        return found;
    };
    const oracle::SegmentTruth found = truth_of(1);
    truth.meet = found.met() ? Meet::yes : Meet::no;
    if (!found.met()) return truth;
    double low = 0, high = 1;
    while (high - low > 1e-12) {
        const double middle = (low + high) / 2;
        (found.within(0, middle) ? high : low) = middle;
    }
    truth.lower = found.within(0, 0) ? 0 : low, truth.upper = high;
    return truth;
}

/// By integers, with the ray as a triangle of no area.
bool ray_confirmed(const LeagueCase& asked, const LeagueTruth& truth)
{
    const Vector3d to = asked.from + asked.motion;
    const auto& mesh = std::get<Mesh>(asked.a.geometry);
    bool met = false;
    for (std::uint32_t t = 0; t < mesh.triangles.size() && !met; ++t)
        met = oracle::contact({asked.from, to, to}, corners_of(mesh, t)) != TriangleContact::separate;
    return met == (truth.meet == Meet::yes);
}

LeagueFamily ray_family(std::string name, std::string what,
                        std::function<void(CaseNumbers&, const Mesh&, LeagueCase&)> aim)
{
    return {"rays: " + std::move(name),
            "rays",
            LEAGUE_RAY,
            std::move(what),
            [aim](std::uint64_t seed) {
                CaseNumbers draw(seed);
                LeagueCase asked{.question = LEAGUE_RAY};
                Mesh mesh =
                    draw.number(0, 1) ? gridded(make_sphere_mesh(1, 80)) : gridded(make_soup_mesh(40, 1, 2, seed));
                aim(draw, mesh, asked);
                asked.a.geometry = std::move(mesh);
                return asked;
            },
            ray_truth,
            ray_confirmed};
}

Vector3d grid_point(CaseNumbers& draw, double reach)
{
    return (draw.vector() * reach).unaryExpr([](double x) { return std::round(x * 1024) / 1024; });
}

/// A ray through a point, as long again behind it.
void through(LeagueCase& asked, const Vector3d& from, const Vector3d& point)
{
    asked.from = from, asked.motion = 2 * (point - from);
}

} // namespace

std::vector<LeagueFamily> motion_league()
{
    const auto corners = [](CaseNumbers& draw, const Mesh& mesh) {
        return corners_of(mesh, draw.number(0u, std::uint32_t(mesh.triangles.size() - 1)));
    };
    return {cast_family("shapes", "Shapes of all kinds that fly past or into each other.",
                        [](CaseNumbers& draw, std::uint64_t seed) { return aimed(draw, seed, draw.real(1.1, 4), 1); }),
            cast_family(
                "thin plates, fast", "Plates of 1e-5 to 1e-2 of their size that fly a thousand times their thickness.",
                [](CaseNumbers& draw, std::uint64_t) {
                    LeagueCase asked{.a = {plate(1, draw.magnitude(-16, -6))},
                                     .b = {plate(1, draw.magnitude(-16, -6))}};
                    asked.b.pose.linear() = draw.one_in(2) ? Eigen::Matrix3d::Identity().eval() : draw.rotation();
                    asked.b.pose.translation() =
                        Vector3d(0.2 * draw.real(-1, 1), 0.2 * draw.real(-1, 1), -draw.real(4, 40));
                    asked.motion = {draw.real(-1, 1), draw.real(-1, 1), draw.real(20, 200)};
                    return asked;
                }),
            cast_family("grazing", "Spheres and boxes that pass each other nearly at a touch.",
                        [](CaseNumbers& draw, std::uint64_t) {
                            LeagueCase asked{.a = {draw.number(0, 1) ? Shape(Sphere{1}) : Shape(Box{{1, 1, 1}})},
                                             .b = {Shape(Sphere{0.5})}};
                            asked.b.pose.translation() =
                                Vector3d(-6, 0.3 * draw.real(-1, 1), 1.5 + draw.sign() * draw.magnitude(-20, -3));
                            asked.motion = {12, 0, 0};
                            return asked;
                        }),
            cast_family("start in contact", "Shapes that overlap from the beginning.",
                        [](CaseNumbers& draw, std::uint64_t seed) {
                            LeagueCase asked = aimed(draw, seed, 2, 1);
                            asked.b.pose.translation() = asked.a.pose.translation();
                            return asked;
                        }),
            ray_family("random", "Rays that start anywhere, against a ball of 80 triangles or loose triangles.",
                       [](CaseNumbers& draw, const Mesh&, LeagueCase& asked) {
                           through(asked, grid_point(draw, 4), grid_point(draw, 1.5));
                       }),
            ray_family("through vertices", "Rays exactly through a vertex.",
                       [corners](CaseNumbers& draw, const Mesh& mesh, LeagueCase& asked) {
                           through(asked, grid_point(draw, 4), corners(draw, mesh)[0]);
                       }),
            ray_family("through edges", "Rays exactly through the middle of an edge.",
                       [corners](CaseNumbers& draw, const Mesh& mesh, LeagueCase& asked) {
                           const TrianglePoints t = corners(draw, mesh);
                           through(asked, grid_point(draw, 4), (t[0] + t[1]) / 2);
                       }),
            ray_family("in a plane", "Rays in the plane of a triangle.",
                       [corners](CaseNumbers& draw, const Mesh& mesh, LeagueCase& asked) {
                           const TrianglePoints t = corners(draw, mesh);
                           const double k = draw.number(-3, 3), m = draw.number(-3, 3);
                           through(asked, t[0] + k * (t[1] - t[0]) + m * (t[2] - t[0]), (t[0] + t[1]) / 2);
                       }),
            ray_family("start on the surface", "Rays that start at a vertex or on an edge.",
                       [corners](CaseNumbers& draw, const Mesh& mesh, LeagueCase& asked) {
                           const TrianglePoints t = corners(draw, mesh);
                           through(asked, draw.number(0, 1) ? t[0] : Vector3d((t[0] + t[1]) / 2), grid_point(draw, 4));
                       })};
}

} // namespace oncollide::tools
