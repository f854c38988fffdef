// Two triangles, and two meshes.
#include <memory>

#include "league/families/families.hpp"
#include "league/truths/truths.hpp"
#include "truth/truth.hpp"
#include "verify/cases/body_case.hpp"
#include "verify/cases/near_families.hpp"
#include "verify/cases/triangle_families.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;

LeagueCase case_of(league_question question, const TwoTriangles& pair)
{
    const auto body = [](const TrianglePoints& t) {
        return LeagueBody{make_mesh("triangle", {t[0], t[1], t[2]}, {{0, 1, 2}})};
    };
    return {.question = question, .a = body(pair.first), .b = body(pair.second)};
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
            truths::meshes_meet,
            truths::meshes_confirmed};
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
                       truths::triangles_meet, truths::meeting_confirmed});
    for (const NearFamily& family : near_families())
        all.push_back(
            {"distance: " + family.name, "distances", LEAGUE_DISTANCE,
             "Two triangles where rounded arithmetic finds distances badly; the truth is rational arithmetic.",
             [family](std::uint64_t seed) { return case_of(LEAGUE_DISTANCE, draw_near(family, seed)); },
             truths::triangles_apart, truths::distance_confirmed});
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
