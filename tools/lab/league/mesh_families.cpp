// Two triangles, and two meshes.
#include <algorithm>
#include <map>
#include <memory>

#include <oncollide/narrowphase/exact/triangle_test.hpp>

#include "league/families.hpp"
#include "truth/exact_oracle.hpp"
#include "truth/triangle_distance.hpp"
#include "truth/truth.hpp"
#include "verify/cases/body_case.hpp"
#include "verify/cases/near_families.hpp"
#include "verify/cases/triangle_families.hpp"
#include "verify/oracle/exact_distance.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;
using Meet = LeagueTruth::Meet;

LeagueCase case_of(league_question question, const TwoTriangles& pair)
{
    const auto body = [](const TrianglePoints& t) {
        return LeagueBody{make_mesh("triangle", {t[0], t[1], t[2]}, {{0, 1, 2}})};
    };
    return {.question = question, .a = body(pair.first), .b = body(pair.second)};
}

TrianglePoints triangle_of(const LeagueBody& body)
{
    const auto& v = std::get<Mesh>(body.geometry).vertices;
    return {v[0], v[1], v[2]};
}

LeagueTruth truth_about(const LeagueCase& asked)
{
    LeagueTruth truth{.size = asked.a.size() + asked.b.size()};
    for (const LeagueBody* body : {&asked.a, &asked.b}) {
        const Aabb box = bounds_of(body->geometry);
        truth.coordinate = std::max({truth.coordinate, box.min.cwiseAbs().maxCoeff(), box.max.cwiseAbs().maxCoeff()});
    }
    return truth;
}

LeagueTruth triangles_meet(const LeagueCase& asked)
{
    LeagueTruth truth = truth_about(asked);
    truth.exact = true;
    truth.meet =
        oracle::contact(triangle_of(asked.a), triangle_of(asked.b)) != TriangleContact::separate ? Meet::yes : Meet::no;
    return truth;
}

/// By rational arithmetic instead of integers.
bool triangles_confirmed(const LeagueCase& asked, const LeagueTruth& truth)
{
    return (oracle::ExactDistance(triangle_of(asked.a), triangle_of(asked.b)).compare(0) == 0) ==
           (truth.meet == Meet::yes);
}

/// By integers whether they meet, and by long double how far apart they are.
bool distance_confirmed(const LeagueCase& asked, const LeagueTruth& truth)
{
    const TrianglePoints a = triangle_of(asked.a), b = triangle_of(asked.b);
    const auto wide = [](const TrianglePoints& t) {
        return TriangleL{t[0].cast<long double>(), t[1].cast<long double>(), t[2].cast<long double>()};
    };
    const DistanceRange range = triangle_distance(wide(a), wide(b));
    const long double rounding = 1e-17L * truth.coordinate;
    return (oracle::contact(a, b) != TriangleContact::separate) == (truth.meet == Meet::yes) &&
           range.low <= truth.upper + rounding && range.high >= truth.lower - rounding;
}

/// By the distance of all pairs of triangles in long double: it cannot be large where they meet, or 0 where they do
/// not.
bool meshes_confirmed(const LeagueCase& asked, const LeagueTruth& truth)
{
    if (asked.a.solid) return true;
    const TruthModel a(std::get<Mesh>(asked.a.geometry), false), b(std::get<Mesh>(asked.b.geometry), false);
    const DistanceTruth distance = surface_distance(a.halved(), asked.a.pose, b.halved(), asked.b.pose);
    const double rounding = 1e-15 * distance.size;
    return truth.meet == Meet::yes ? distance.low <= rounding : distance.high > 0;
}

LeagueTruth triangles_apart(const LeagueCase& asked)
{
    LeagueTruth truth = truth_about(asked);
    const TrianglePoints a = triangle_of(asked.a), b = triangle_of(asked.b);
    const oracle::ExactDistance distance(a, b);
    truth.lower = truth.upper = truth.gap = distance.value();
    truth.meet = distance.compare(0) == 0 ? Meet::yes : Meet::no;
    truth.off_surface = [a, b](const Vector3d& point, int of) {
        return oracle::ExactDistance({point, point, point}, of ? b : a).value();
    };
    return truth;
}

/// Exact motions of both bodies: a scale by a power of two, and one of 24 rotations by quarter turns.
Mesh moved_exactly(const Mesh& mesh, const Eigen::Isometry3d& pose, std::uint64_t variation)
{
    CaseNumbers draw(variation);
    const double scale = variation ? std::ldexp(1.0, draw.number(-6, 6)) : 1;
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    if (variation) {
        const int first = draw.number(0, 2), second = (first + draw.number(1, 2)) % 3;
        turn.setZero(), turn(first, 0) = draw.sign(), turn(second, 1) = draw.sign();
        turn.col(2) = turn.col(0).cross(turn.col(1));
    }
    std::vector<Vector3d> vertices;
    for (const Vector3d& v : mesh.vertices) vertices.push_back(scale * (turn * (pose * v)));
    return make_mesh("mesh", std::move(vertices), mesh.triangles);
}

LeagueFamily mesh_family(std::string name, std::string what, std::vector<BodyCase> (*make)(), bool solid)
{
    auto cases = std::make_shared<std::vector<BodyCase>>(make());
    if (solid) std::erase_if(*cases, [](const BodyCase& c) { return !has_inside(c.a) || !has_inside(c.b); });
    return {std::move(name),
            "meshes",
            LEAGUE_MEET,
            std::move(what),
            [cases, solid](std::uint64_t seed) {
                const BodyCase& c = (*cases)[seed % cases->size()];
                const std::uint64_t variation = seed / cases->size();
                return LeagueCase{.question = LEAGUE_MEET,
                                  .a = {moved_exactly(c.a, c.pose_a, variation), Eigen::Isometry3d::Identity(), solid},
                                  .b = {moved_exactly(c.b, c.poses_b[variation % c.poses_b.size()], variation),
                                        Eigen::Isometry3d::Identity(), solid}};
            },
            [](const LeagueCase& asked) {
                LeagueTruth truth = truth_about(asked);
                truth.exact = true;
                const TruthModel a(asked.a.geometry, asked.a.solid), b(asked.b.geometry, asked.b.solid);
                const PairTruth found =
                    truth_of(a, asked.a.pose, b, asked.b.pose, {.kinds = false, .deep = false, .distance = false});
                truth.meet = found.collide || (asked.a.solid && found.enclosed) ? Meet::yes : Meet::no;
                return truth;
            },
            meshes_confirmed};
}

} // namespace

std::vector<LeagueFamily> triangle_league()
{
    std::vector<LeagueFamily> all;
    for (const TriangleFamily& family : triangle_families())
        all.push_back({"triangles: " + family.name, "triangles", LEAGUE_MEET,
                       "Two triangles on a grid of 2^-20 m; the truth is linear programming in integers.",
                       [family](std::uint64_t seed) {
                           GridPoints draw(seed);
                           TwoTriangles pair = family.make(draw);
                           for (TrianglePoints* t : {&pair.first, &pair.second})
                               for (Vector3d& p : *t) p *= 0x1p-20;
                           return case_of(LEAGUE_MEET, pair);
                       },
                       triangles_meet, triangles_confirmed});
    for (const NearFamily& family : near_families())
        all.push_back(
            {"distance: " + family.name, "distances", LEAGUE_DISTANCE,
             "Two triangles where rounded arithmetic finds distances badly; the truth is rational arithmetic.",
             [family](std::uint64_t seed) { return case_of(LEAGUE_DISTANCE, draw_near(family, seed)); },
             triangles_apart, distance_confirmed});
    return all;
}

std::vector<LeagueFamily> mesh_league()
{
    return {mesh_family("meshes: touching", "Boxes, walls, twins and plates that touch or nearly do.", contact_cases,
                        false),
            mesh_family("meshes: slivers and open", "Slivers, needles, triangles without area, open meshes.",
                        shape_cases, false),
            mesh_family("meshes: scales", "One inside another, tiny, huge, far from the origin, sizes far apart.",
                        scale_cases, false),
            mesh_family("solids: enclosed", "Solids inside others, in cavities, of several parts; the inside counts.",
                        solid_cases, true)};
}

} // namespace oncollide::tools
