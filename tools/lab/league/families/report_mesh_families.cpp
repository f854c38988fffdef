// Situations from public bug reports of other libraries, rebuilt: triangles and meshes.
#include <cmath>
#include <numbers>

#include <oncollide/narrowphase/exact/triangle_test.hpp>
#include <oncollide/samples/generators.hpp>

#include "league/families/report_families.hpp"
#include "league/truths/truths.hpp"
#include "verify/cases/body_case.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr ReportTruth two_triangles{LEAGUE_MEET, truths::triangles_meet, truths::meeting_confirmed},
    two_meshes{LEAGUE_MEET, truths::meshes_meet, truths::meshes_confirmed};

/// One triangle, which may be a point or a line, through the origin.
TrianglePoints flat_triangle(CaseNumbers& draw)
{
    const Vector3d u = whole_point(draw, 5) + Vector3d(0, 0, 6), v = whole_point(draw, 5) + Vector3d(6, 0, 0);
    switch (draw.number(0, 3)) {
    case 0:
        return {Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()};
    case 1:
        return {-u, 2 * u, 2 * u};
    case 2:
        return {-u, draw.number(0, 3) * u, 3 * u};
    default:
        return {-u, 2 * u - v, v};
    }
}

LeagueBody triangle_body(const TrianglePoints& corners, double scale, const Vector3d& by)
{
    std::vector<Vector3d> moved;
    for (const Vector3d& p : corners) moved.push_back(scale * p + by);
    return {mesh_of(moved)};
}

/// A disc of triangles around its middle.
Mesh fan_of(int corners, double radius, double turn, const Vector3d& by, const Matrix3d& tilt)
{
    std::vector<Vector3d> points;
    const auto rim = [&](int k) {
        const double angle = turn + 2 * std::numbers::pi * (k % corners) / corners;
        return Vector3d(radius * std::cos(angle), radius * std::sin(angle), 0);
    };
    for (int k = 0; k < corners; ++k)
        for (const Vector3d& p : {Vector3d(Vector3d::Zero()), rim(k), rim(k + 1)}) points.push_back(tilt * (p + by));
    return mesh_of(points);
}

LeagueCase cube_and_lines(CaseNumbers& draw)
{
    std::vector<Vector3d> corners;
    for (int k = draw.number(1, 6); k > 0; --k) {
        Vector3d p = whole_point(draw, 7) / 8, q = whole_point(draw, 7) / 8;
        p.z() = 1 + (draw.one_in(3) ? draw.magnitude(-3, 3) : touch_or_gap(draw, -48, -8));
        q.z() = draw.one_in(4) ? 0 : p.z() + draw.number(0, 2);
        if (draw.number(0, 1)) q = p;
        corners.insert(corners.end(), {p, q, draw.number(0, 1) ? p : q});
    }
    return {.a = {make_box_mesh(Vector3d::Ones())}, .b = {mesh_of(corners)}};
}

LeagueCase turned_fans(CaseNumbers& draw)
{
    const int a = draw.number(5, 9), b = draw.number(5, 9);
    const double r = draw.real(0.5, 2), turn = draw.real(0, 1), gap = touch_or_gap(draw, -52, -8);
    const Matrix3d tilt = turn_or_none(draw);
    const bool stacked = draw.number(0, 1);
    const Vector3d by = stacked ? Vector3d(0, 0, gap) : Vector3d(1 + r + gap, 0, 0);
    return {.a = {fan_of(a, 1, 0, Vector3d::Zero(), tilt)},
            .b = {fan_of(b, r, stacked ? turn : std::numbers::pi, by, tilt)}};
}

LeagueCase millimetres_far_out(CaseNumbers& draw)
{
    const Vector3d place = 300 * draw.vector();
    const auto corner = [&] { return Vector3d(place + 1e-3 * draw.vector()); };
    const TrianglePoints a{corner(), corner(), corner()};
    TrianglePoints b{corner(), corner(), corner()};
    if (draw.number(0, 1)) { // one corner or an edge's middle is on a's plane, as far as rounding allows
        const double u = draw.real(0, 0.5), v = draw.real(0, 0.5);
        const Vector3d on = a[0] + u * (a[1] - a[0]) + v * (a[2] - a[0]);
        b[0] = draw.number(0, 1) ? on : Vector3d(2 * on - b[1]);
    }
    return {.a = triangle_body(a, 1, Vector3d::Zero()), .b = triangle_body(b, 1, Vector3d::Zero())};
}

/// A cube whose triangles share no vertices and have any winding, and a plate without thickness or another cube.
LeagueCase unwelded(CaseNumbers& draw)
{
    const auto loose = [&](const Vector3d& half, const Vector3d& by) {
        const Mesh mesh = make_box_mesh(Vector3d::Ones());
        std::vector<Vector3d> corners;
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            TrianglePoints c = corners_of(mesh, t);
            if (draw.number(0, 1)) std::swap(c[1], c[2]);
            for (const Vector3d& p : c) corners.emplace_back(half.cwiseProduct(p) + by);
        }
        return mesh_of(corners);
    };
    const Vector3d place = draw.number(0, 1) ? Vector3d(Vector3d::Zero()) : 1e6 * draw.vector();
    const double thickness = draw.number(0, 1) ? 0 : 0.5, side = draw.real(0.1, 0.9);
    const Vector3d by(0.5 * draw.real(-1, 1), 0.5 * draw.real(-1, 1), 1 + thickness + touch_or_gap(draw, -40, -2));
    const bool inside = draw.one_in(4);
    return {.a = {loose(Vector3d::Ones(), place)},
            .b = {loose({side, side, inside ? side : thickness},
                        inside ? Vector3d(place + 1e-3 * draw.vector()) : Vector3d(place + by))}};
}

} // namespace

std::vector<LeagueFamily> report_mesh_league()
{
    return {
        report_family("triangles without area, three-mesh-bvh#762", two_meshes,
                      "Triangles that are points or lines lie near a cube's face, on it, or in it.", cube_and_lines),
        report_family("points and lines as triangles, CGAL#8146", two_triangles,
                      "A triangle that is a point, a line or a proper one touches another, or is just beside it.",
                      [](CaseNumbers& draw) {
                          const Vector3d by = touch_or_gap(draw, -50, 2) * draw.vector();
                          return LeagueCase{.a = triangle_body(flat_triangle(draw), 0.125, Vector3d::Zero()),
                                            .b = triangle_body(flat_triangle(draw), 0.125, by)};
                      }),
        report_family("fans of turned caps, three-bvh-csg#56", two_meshes,
                      "The end caps of two cylinders lie on each other, or touch with their rims.", turned_fans),
        report_family("triangles of mm at 300 m, CGAL#8605", two_triangles,
                      "Two triangles of a millimetre lie 300 m from the origin, and often they just touch.",
                      millimetres_far_out),
        report_family("unwelded meshes of mixed winding", two_meshes,
                      "Triangles share no vertices and face any way; one mesh is inside the other, or a thin plate.",
                      unwelded)};
}

} // namespace oncollide::tools
