// Shapes that move until they meet others, and rays against meshes.
#include <cmath>

#include "league/families/moving_family.hpp"
#include "league/truths/truths.hpp"
#include "verify/cases/drawn_shapes.hpp"

#include <oncollide/narrowphase/exact/triangle_test.hpp>
#include <oncollide/samples/generators.hpp>

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;

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
            truths::first_hit,
            truths::hit_confirmed};
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
    return {
        moving_family(LEAGUE_CAST, "shapes", "Shapes of all kinds that fly past or into each other.",
                      [](CaseNumbers& draw, std::uint64_t seed) { return aimed(draw, seed, draw.real(1.1, 4), 1); }),
        moving_family(LEAGUE_CAST, "thin plates, fast",
                      "Plates of 1e-5 to 1e-2 of their size that fly a thousand times their thickness.",
                      [](CaseNumbers& draw, std::uint64_t) {
                          LeagueCase asked{.a = {plate(1, draw.magnitude(-16, -6))},
                                           .b = {plate(1, draw.magnitude(-16, -6))}};
                          asked.b.pose.linear() = draw.one_in(2) ? Eigen::Matrix3d::Identity().eval() : draw.rotation();
                          asked.b.pose.translation() =
                              Vector3d(0.2 * draw.real(-1, 1), 0.2 * draw.real(-1, 1), -draw.real(4, 40));
                          asked.motion = {draw.real(-1, 1), draw.real(-1, 1), draw.real(20, 200)};
                          return asked;
                      }),
        moving_family(LEAGUE_CAST, "grazing", "Spheres and boxes that pass each other nearly at a touch.",
                      [](CaseNumbers& draw, std::uint64_t) {
                          LeagueCase asked{.a = {draw.number(0, 1) ? Shape(Sphere{1}) : Shape(Box{{1, 1, 1}})},
                                           .b = {Shape(Sphere{0.5})}};
                          asked.b.pose.translation() =
                              Vector3d(-6, 0.3 * draw.real(-1, 1), 1.5 + draw.sign() * draw.magnitude(-20, -3));
                          asked.motion = {12, 0, 0};
                          return asked;
                      }),
        moving_family(LEAGUE_CAST, "start in contact", "Shapes that overlap from the beginning.",
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
