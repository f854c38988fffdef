// Shapes that turn while they move.
#include <cmath>
#include <numbers>

#include "league/families/moving_family.hpp"
#include "verify/cases/drawn_shapes.hpp"

#include <oncollide/samples/generators.hpp>

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;

/// A shape of the size 0.3 to 2, of any kind except half-spaces.
Shape draw_shape(CaseNumbers& draw)
{
    const Vector3d lengths(draw.real(0.1, 1), draw.real(0.1, 1), draw.real(0.1, 1));
    switch (draw.number(0, 6)) {
    case 0:
        return Sphere{lengths.x()};
    case 1:
        return Capsule{lengths.x() / 2, 2 * lengths.z()};
    case 2:
        return Box{lengths};
    case 3: {
        ConvexHull hull{{{lengths.x(), 0, 0}, {0, lengths.y(), 0}, {0, 0, lengths.z()}, -lengths}};
        for (int k = draw.number(0, 6); k > 0; --k) hull.points.push_back(draw.vector());
        return hull;
    }
    case 4:
        return Cylinder{lengths.x(), 2 * lengths.z()};
    case 5:
        return Cone{lengths.x(), 2 * lengths.z()};
    default:
        return Ellipsoid{lengths};
    }
}

Vector3d unit(CaseNumbers& draw)
{
    return (draw.vector() + Vector3d(0, 0, 1e-3)).normalized();
}

/// The ground on which a shape tumbles: its geometry, and whether it is a solid mesh.
LeagueBody draw_ground(GroundKind kind, CaseNumbers& draw)
{
    if (kind == GroundKind::mesh) return {make_box_mesh({1, 1.5, 0.5}), Eigen::Isometry3d::Identity(), true};
    if (kind == GroundKind::map) {
        const MapCell cells[] = {{-1, -1, 0, 1}, {0, 0, 0, 1}, {draw.number(-1, 0), 0, -1, 1}};
        return {make_occupancy_map("map", 1, cells)};
    }
    const TerrainGrid grid{.columns = 3, .rows = 3, .origin = {-1, -1, 0}, .bytes = 8};
    std::vector<double> heights;
    for (int k = 0; k < 9; ++k) heights.push_back(0.25 * draw.number(0, 3));
    return {make_terrain("terrain", grid, heights)};
}

/// A shape comes from outside toward the point 0, and turns up to two times.
LeagueCase tumbling(LeagueBody a, CaseNumbers& draw)
{
    LeagueCase asked{.a = std::move(a), .b = {draw_shape(draw)}};
    const Vector3d way = unit(draw);
    asked.b.pose.linear() = draw.rotation(), asked.b.pose.translation() = -draw.real(3, 6) * way;
    asked.motion = draw.real(3, 12) * way + 0.8 * draw.vector();
    asked.turn = draw.real(0, 4 * std::numbers::pi) * unit(draw);
    return asked;
}

/// A rod or plate that turns around the end of it, which rests, toward a small ball or box.
LeagueCase swinging(double aside, CaseNumbers& draw)
{
    const double thin = draw.magnitude(-10, -3), length = draw.real(0.5, 2);
    LeagueCase asked{.a = {draw.number(0, 1) ? Shape(Sphere{0.125}) : Shape(Box{{0.125, 0.125, 0.125}})}};
    // A body turns about its own origin, so the rod is a hull that begins there.
    ConvexHull rod;
    for (const double x : {0.0, length})
        for (const double y : {-thin, thin})
            for (const double z : {-thin, thin}) rod.points.emplace_back(x, y, z);
    asked.b.geometry = Shape(std::move(rod));
    const double reach = length + 0.125 + aside;
    asked.b.pose.translation() = Vector3d(-reach, 0, draw.real(-0.05, 0.05));
    const double from = draw.real(0.5, 3), to = draw.real(0.5, 3);
    asked.b.pose.linear() = Eigen::AngleAxisd(-from, Vector3d::UnitZ()).toRotationMatrix();
    asked.turn = (from + to) * Vector3d::UnitZ();
    return asked;
}

} // namespace

std::vector<LeagueFamily> turn_league()
{
    std::vector<LeagueFamily> all{
        moving_family(LEAGUE_TURN, "shapes that tumble",
                      "Shapes of all kinds that fly past or into each other, with up to two turns.",
                      [](CaseNumbers& draw, std::uint64_t) {
                          LeagueBody a{draw_shape(draw)};
                          a.pose.linear() = draw.rotation();
                          return tumbling(std::move(a), draw);
                      }),
        moving_family(LEAGUE_TURN, "rotation alone",
                      "Thin rods that swing around one end, which rests, past or into a small body.",
                      [](CaseNumbers& draw, std::uint64_t) { return swinging(draw.real(-0.4, 0.1), draw); }),
        moving_family(
            LEAGUE_TURN, "grazing", "Thin rods whose swinging end touches a small body, or passes it closely.",
            [](CaseNumbers& draw, std::uint64_t) { return swinging(draw.sign() * draw.magnitude(-14, -6), draw); }),
        moving_family(LEAGUE_TURN, "thin plates, fast",
                      "Plates of 1e-3 to .1 of their size that fly and spin past or through a plate.",
                      [](CaseNumbers& draw, std::uint64_t) {
                          LeagueCase asked{.a = {Shape(Box{{1, 1, draw.magnitude(-10, -4)}})},
                                           .b = {Shape(Box{{0.5, 0.5, draw.magnitude(-10, -4)}})}};
                          asked.b.pose.linear() = draw.rotation();
                          asked.b.pose.translation() = Vector3d(draw.real(-1, 1), draw.real(-1, 1), -draw.real(2, 10));
                          asked.motion = {draw.real(-1, 1), draw.real(-1, 1), draw.real(10, 40)};
                          asked.turn = draw.real(0, 20) * unit(draw);
                          return asked;
                      })};
    for (const GroundKind kind : {GroundKind::mesh, GroundKind::terrain, GroundKind::map})
        all.push_back(moving_family(
            LEAGUE_TURN, std::string("shapes that tumble on a ") + std::string(ground_kinds[std::size_t(kind)]),
            "Shapes of all kinds that fly and turn toward a mesh, a terrain or the cells of a map.",
            [kind](CaseNumbers& draw, std::uint64_t) {
                LeagueBody ground = draw_ground(kind, draw);
                return tumbling(std::move(ground), draw);
            }));
    return all;
}

} // namespace oncollide::tools
