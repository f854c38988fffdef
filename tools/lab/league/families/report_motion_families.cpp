// Situations from public bug reports of other libraries, rebuilt: bodies that move, and rays.
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

constexpr ReportTruth cast{LEAGUE_CAST, truths::first_contact, truths::contact_confirmed},
    ray{LEAGUE_RAY, truths::first_hit, truths::hit_confirmed};

/// The motion goes through a point, and as far beyond it.
LeagueCase ray_through(LeagueBody target, const Vector3d& from, const Vector3d& point)
{
    return {.a = std::move(target), .from = from, .motion = 2 * (point - from)};
}

/// A point whose coordinates are multiples of 2^-6, away from the origin by at least `least` along z.
Vector3d sixty_fourths(CaseNumbers& draw, double reach, double least = 0)
{
    const auto round = [](double x) { return std::round(64 * x) / 64; };
    const Vector3d p = reach * draw.vector();
    return {round(p.x()), round(p.y()), round(p.z() + std::copysign(least, p.z()))};
}

/// The rectangle |x| <= half_x, |y| <= half_y at z = 0, of two triangles.
Mesh flat_wall(double half_x, double half_y)
{
    return mesh_of({{-half_x, -half_y, 0}, {half_x, -half_y, 0}, {half_x, half_y, 0}, {-half_x, half_y, 0}},
                   {{0, 1, 2}, {0, 2, 3}});
}

/// Two rectangles that meet in the y axis, the ridge of a roof.
Mesh roof(double length, double width, double slope)
{
    const double drop = -slope * width;
    return mesh_of({{0, -length, 0},
                    {0, length, 0},
                    {width, -length, drop},
                    {width, length, drop},
                    {-width, -length, drop},
                    {-width, length, drop}},
                   {{0, 2, 3}, {0, 3, 1}, {0, 1, 5}, {0, 5, 4}});
}

/// A closed prism around z, or a cone if its top has no radius; corners are multiples of 2^-10 of `scale`.
Mesh prism_mesh(int corners, double top, double half, double scale)
{
    std::vector<Vector3d> points{{0, 0, -half}, {0, 0, half}};
    const auto rim = [&](int k, double radius, double z) {
        const double angle = 2 * std::numbers::pi * k / corners;
        return Vector3d(std::round(1024 * radius * std::cos(angle)) / 1024,
                        std::round(1024 * radius * std::sin(angle)) / 1024, z);
    };
    std::vector<Triangle> triangles;
    for (int k = 0; k < corners; ++k) points.push_back(rim(k, 1, -half)), points.push_back(rim(k, top, half));
    for (int k = 0; k < corners; ++k) {
        const std::uint32_t low = 2 + 2 * k, next = 2 + 2 * ((k + 1) % corners);
        triangles.push_back({0, next, low});
        triangles.push_back({low, next, low + 1});
        if (top > 0) triangles.push_back({1, low + 1, next + 1}), triangles.push_back({next, next + 1, low + 1});
    }
    for (Vector3d& p : points) p *= scale;
    return mesh_of(std::move(points), std::move(triangles));
}

/// A capsule along x, or along another axis of the plane across z.
Matrix3d lying(double angle)
{
    return turn_by(angle, Vector3d::UnitZ()) * turn_by(std::numbers::pi / 2, Vector3d::UnitY());
}

LeagueCase capsule_onto_ridge(CaseNumbers& draw)
{
    const double radius = draw.real(0.05, 0.5), height = draw.real(0.6, 4),
                 angle = draw.number(0, 2) * std::numbers::pi / 4;
    LeagueCase asked;
    asked.a.geometry = roof(draw.real(2, 5), draw.real(0.5, 4), draw.real(0, 3));
    asked.b =
        placed(Capsule{radius, draw.real(0.2, 2)}, {0.5 * draw.real(-1, 1), draw.real(-1, 1), height}, lying(angle));
    asked.motion = {0.1 * draw.real(-1, 1), 0.1 * draw.real(-1, 1), -height - draw.real(0.1, 1) * radius};
    return turned_together(asked, turn_or_none(draw));
}

LeagueCase capsule_beside_edge(CaseNumbers& draw)
{
    const double radius = draw.real(0.1, 0.5), half = draw.real(0.2, 1),
                 aside = draw.sign() * radius * draw.magnitude(-7, -2);
    LeagueCase asked{.a = {flat_wall(1, 4)},
                     .b = placed(Capsule{radius, 2 * half}, {1 + radius + aside, draw.real(-2, 2), 3})};
    asked.motion = {0, draw.number(0, 1) * draw.real(-1, 1), -draw.real(4, 8)};
    return asked;
}

LeagueCase ball_and_sliver(CaseNumbers& draw)
{
    const double length = draw.real(1, 4), width = draw.magnitude(-18, -6), radius = draw.real(0.1, 0.5);
    const Vector3d near = draw.number(0, 1) ? Vector3d(0.3 * length, 0, 0) : Vector3d(0.3 * length, 2, 0);
    LeagueCase asked{.a = {mesh_of({Vector3d(0, 0, 0), Vector3d(length, 0, 0), Vector3d(0.5 * length, width, 0)})}};
    const Vector3d way = Vector3d(0.2 * draw.real(-1, 1), 0.2 * draw.real(-1, 1), -1),
                   from = near - draw.real(1, 5) * way;
    asked.b = placed(Sphere{radius}, from), asked.motion = 1.05 * (near - from);
    return turned_together(asked, turn_or_none(draw));
}

LeagueCase ball_close_to_wall(CaseNumbers& draw)
{
    const double radius = draw.real(0.1, 1), gap = draw.magnitude(-10, -6);
    const bool mesh = draw.number(0, 1);
    const Vector3d into(draw.real(-1, 1), draw.real(-1, 1), -gap - radius * draw.magnitude(-4, 0));
    LeagueCase asked{.a = mesh ? LeagueBody{flat_wall(5, 5)} : placed(Box{{5, 5, 0.5}}, {0, 0, -0.5}),
                     .b = placed(Sphere{radius}, {0, 0, radius + gap}),
                     .motion = into};
    return turned_together(asked, turn_or_none(draw));
}

LeagueCase slide_along_floor(CaseNumbers& draw)
{
    const double radius = draw.real(0.1, 1), deep = radius * draw.magnitude(-7, -2);
    Mesh floor = flat_wall(5, 5);
    if (draw.number(0, 1))
        floor = joined(floor, rotated(floor, turn_by(std::numbers::pi / 2, Vector3d::UnitY()), {4, 0, 0}));
    LeagueCase asked{.a = draw.number(0, 1) ? LeagueBody{floor} : placed(Box{{5, 5, 0.5}}, {0, 0, -0.5}),
                     .b = placed(Sphere{radius}, {draw.real(-2, 2), draw.real(-2, 2), radius - deep})};
    asked.motion = {draw.real(1, 6), draw.real(-1, 1), draw.number(0, 1) * draw.real(0, 1)};
    return asked;
}

std::vector<LeagueFamily> cast_reports()
{
    return {
        report_family(
            "ball onto a huge slab, parry#429", cast, "A ball falls onto a slab that is many times as wide.",
            [](CaseNumbers& draw) {
                const double radius = draw.real(0.1, 1), thick = draw.real(0.5, 5), height = draw.real(0.5, 50);
                const Vector3d at(draw.real(-20, 20), draw.real(-20, 20), thick + radius + height);
                return LeagueCase{.a = placed(Box{{draw.real(50, 500), draw.real(50, 500), thick}}),
                                  .b = placed(Sphere{radius}, at),
                                  .motion = {draw.real(-5, 5), draw.real(-5, 5), -height - draw.real(0.1, 1) * radius}};
            }),
        report_family("ball close to a wall, parry#107", cast,
                      "A ball starts some millimetres from a wall and moves at a slant into it.", ball_close_to_wall),
        report_family("target with a rotation, parry#19", cast,
                      "A ball flies past or into a long box that has a rotation.",
                      [](CaseNumbers& draw) {
                          const Vector3d aim(2 * draw.real(-1, 1), 2 * draw.real(-1, 1), 0);
                          return LeagueCase{.a = placed(Box{{2, 0.2, 0.2}}, Vector3d::Zero(),
                                                        turn_by(draw.real(0, 6), Vector3d::UnitZ())),
                                            .b = placed(Sphere{draw.real(0.05, 0.3)}, aim + Vector3d(0, 0, 5)),
                                            .motion = {0, 0, -5}};
                      }),
        report_family("capsule onto a ridge, PhysX#597", cast,
                      "A capsule falls onto the edge between triangles of a mesh.", capsule_onto_ridge),
        report_family("capsule beside an edge, PhysX#501", cast,
                      "An upright capsule falls past the edge of a mesh, or touches it with its side.",
                      capsule_beside_edge),
        report_family("wide flat shapes, rapier.js#258", cast,
                      "A flat box or a flat cylinder falls onto another wide plate.",
                      [](CaseNumbers& draw) {
                          const auto half = [&] { return draw.magnitude(-7, -3); };
                          const double a = half(), b = half(), height = draw.real(0.5, 10);
                          const Shape falls = draw.number(0, 1) ? Shape(Box{{draw.real(1, 9), draw.real(1, 9), b}})
                                                                : Shape(Cylinder{draw.real(1, 9), 2 * b});
                          return LeagueCase{
                              .a = placed(Box{{draw.real(2, 20), draw.real(2, 20), a}}),
                              .b = placed(falls, {draw.real(-1, 1), draw.real(-1, 1), a + b + height},
                                          turn_by(draw.number(0, 1) * draw.real(0, 0.1), draw.vector().normalized())),
                              .motion = {draw.real(-1, 1), draw.real(-1, 1), -height - a - b}};
                      }),
        report_family("ball onto rotated slabs, bullet3#596", cast, "A ball flies onto a slab that has any rotation.",
                      [](CaseNumbers& draw) {
                          const Vector3d way = draw.vector().normalized();
                          const double far = draw.real(5, 30);
                          return LeagueCase{.a = placed(Box{{draw.real(1, 4), draw.real(1, 4), draw.real(0.1, 0.5)}},
                                                        Vector3d::Zero(), draw.rotation()),
                                            .b = placed(Sphere{draw.real(0.1, 0.5)}, draw.vector() - far * way),
                                            .motion = far * way};
                      }),
        report_family("start in contact and slide on, rapier#266", cast,
                      "A ball overlaps the floor from the start and moves along it or away.", slide_along_floor),
        report_family("ball and a sliver, Jolt#886", cast,
                      "A ball flies onto a sliver of a triangle, or past it at a distance of 2 m.", ball_and_sliver)};
}

LeagueCase ray_at_rim(CaseNumbers& draw)
{
    const int corners = draw.number(8, 24), k = draw.number(0, corners - 1);
    const Mesh mesh = prism_mesh(corners, draw.number(0, 1), 0.5, 1);
    const Vector3d p = mesh.vertices[2 + 2 * k], q = mesh.vertices[2 + 2 * ((k + 1) % corners)];
    return ray_through({mesh}, sixty_fourths(draw, 4, 1), draw.number(0, 1) ? p : Vector3d((p + q) / 2));
}

/// The ray hits a vertex, an edge or a diagonal inside of a sheet of unit cells, flat or folded at x = 0.
LeagueCase ray_between_triangles(CaseNumbers& draw)
{
    const int half = draw.number(1, 4);
    const double slope = draw.number(0, 1) * 0.5;
    Mesh sheet = make_sheet_mesh(2 * half, 2 * half);
    for (Vector3d& v : sheet.vertices) v.z() = slope * std::abs(v.x());
    const auto inside = [&] { return double(draw.number(1 - half, half - 1)); };
    Vector3d point(inside(), inside(), 0);
    const int on = draw.number(0, 3); // an edge: half a cell aside in x or y; a diagonal: in both
    point.x() += on & 1 ? 0.5 * draw.sign() : 0, point.y() += on & 2 ? 0.5 * draw.sign() : 0;
    point.z() = slope * std::abs(point.x());
    const Vector3d from = draw.number(0, 1) ? Vector3d(point + Vector3d(0, 0, 8)) : sixty_fourths(draw, 8, 4);
    return ray_through({mesh_of(std::move(sheet.vertices), std::move(sheet.triangles))}, from, point);
}

/// The ray is in the plane of the slivers, as far as rounding allows, or a little tilted.
LeagueCase ray_along_slivers(CaseNumbers& draw)
{
    std::vector<Vector3d> corners;
    const Matrix3d turn = turn_or_none(draw);
    const double width = draw.magnitude(-20, -4);
    for (int k = draw.number(1, 6); k > 0; --k) {
        const Vector3d p(draw.real(-1, 1), draw.real(-1, 1), 0), along(draw.real(0.5, 2), draw.real(-1, 1), 0);
        const Vector3d across = width * Vector3d(-along.y(), along.x(), 0);
        for (const Vector3d& c : {p, Vector3d(p + along), Vector3d(p + 0.5 * along + across)})
            corners.push_back(turn * c);
    }
    const Vector3d point = (corners[0] + corners[1] + corners[2]) / 3, normal = turn.col(2);
    const double angle = draw.real(0, 6);
    Vector3d from = point + 3 * (turn * Vector3d(std::cos(angle), std::sin(angle), 0));
    if (!draw.one_in(4)) from += draw.sign() * draw.magnitude(-40, -6) * normal;
    return ray_through({mesh_of(corners)}, from, point);
}

LeagueCase ray_at_far_cone(CaseNumbers& draw)
{
    const Mesh mesh = prism_mesh(draw.number(8, 40), 0, 0.5, 512);
    const Vector3d from = 12288 * Vector3d(draw.vector().normalized());
    return ray_through({mesh}, from.unaryExpr([](double x) { return std::round(x); }), sixty_fourths(draw, 400));
}

LeagueCase lidar_near_perpendicular(CaseNumbers& draw)
{
    const double height = draw.real(0.5, 20);
    const double tilt = draw.one_in(3) ? 0 : draw.magnitude(-50, -4), turn = draw.real(0, 6);
    const Vector3d way(tilt * std::cos(turn), tilt * std::sin(turn), -1);
    const Vector3d from(draw.one_in(3) ? 0 : draw.real(-4, 4), draw.one_in(3) ? 0 : draw.real(-4, 4), height);
    return {.a = {flat_wall(16, 16)}, .from = from, .motion = height * draw.real(0.9, 1.5) * way};
}

LeagueCase ray_in_cells(CaseNumbers& draw)
{
    std::vector<MapCell> cells;
    for (int k = draw.number(1, 60); k > 0; --k) {
        const int side = draw.one_in(4) ? 2 : 1;
        const auto place = [&] { return side * draw.number(-2, 2); };
        cells.push_back({place(), place(), place(), side});
    }
    const auto corner = [&] { return Vector3d(draw.number(-6, 6), draw.number(-6, 6), draw.number(-6, 6)); };
    LeagueCase asked{.a = {make_occupancy_map("map", 0.25, cells)}};
    asked.from = 0.125 * corner();
    switch (draw.number(0, 2)) {
    case 0: // along a grid's line, or a face
        asked.motion[draw.number(0, 2)] = draw.sign() * draw.number(1, 4);
        break;
    case 1: // through corners
        asked.motion = 0.25 * corner() + Vector3d(0, 0, 0.0625);
        break;
    default:
        asked.motion = 2 * sixty_fourths(draw, 1, 0.5);
    }
    return asked;
}

std::vector<LeagueFamily> ray_reports()
{
    return {report_family("rays at the rim, godot#82574", ray,
                          "Rays go exactly through corners and edges of a cylinder's or a cone's rim.", ray_at_rim),
            report_family("rays between triangles, embree#174", ray,
                          "Rays go exactly through vertices and edges that triangles of a flat or folded sheet share.",
                          ray_between_triangles),
            report_family("rays along slivers, embree#387", ray,
                          "Rays are almost parallel to the triangles of a mesh of slivers.", ray_along_slivers),
            report_family("rays from 12 km, PhysX#429", ray, "Rays start 12 km from a cone of 500 m.", ray_at_far_cone),
            report_family("rays of a lidar, drake#1712", ray, "Rays meet the ground at a right angle, or nearly so.",
                          lidar_near_perpendicular),
            report_family("rays in cells, octomap#246", ray,
                          "Rays start in cells of a map, run along their faces, or go through their corners.",
                          ray_in_cells)};
}

} // namespace

std::vector<LeagueFamily> report_motion_league()
{
    std::vector<LeagueFamily> all = cast_reports();
    for (LeagueFamily& family : ray_reports()) all.push_back(std::move(family));
    return all;
}

} // namespace oncollide::tools
