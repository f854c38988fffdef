// Situations from public bug reports of other libraries, rebuilt: bodies at rest.
#include "league/families/report_families.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <oncollide/samples/generators.hpp>

#include "league/truths/truths.hpp"
#include "verify/cases/body_case.hpp"
#include "verify/oracle/solid_truth.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr ReportTruth meeting{LEAGUE_MEET, truths::shapes_apart, truths::gap_confirmed},
    distance{LEAGUE_DISTANCE, truths::shapes_apart, truths::gap_confirmed},
    depth{LEAGUE_DEPTH, truths::shapes_deep, truths::gap_confirmed}, pairs{LEAGUE_PAIRS, truths::overlapping};

Matrix3d about_z(double angle)
{
    return turn_by(angle, Vector3d::UnitZ());
}

/// A prism over a trapezoid.
Shape trapezoid(double bottom, double top, double height, double thickness)
{
    ConvexHull hull;
    for (const double y : {-thickness, thickness})
        for (const auto& [half, z] : {std::pair(bottom, -height), std::pair(top, height)})
            hull.points.emplace_back(-half, y, z), hull.points.emplace_back(half, y, z);
    return hull;
}

/// A shape of one of six kinds, and how far it reaches along z.
std::pair<Shape, double> upright_shape(CaseNumbers& draw)
{
    const double r = draw.real(0.05, 0.5), h = draw.real(0.05, 0.5);
    switch (draw.number(0, 5)) {
    case 0:
        return {Sphere{r}, r};
    case 1:
        return {Capsule{r, 2 * h}, h + r};
    case 2:
        return {Box{{r, r, h}}, h};
    case 3:
        return {Cylinder{r, 2 * h}, h};
    case 4:
        return {Cone{r, 2 * h}, h};
    default:
        return {Ellipsoid{{r, r, h}}, h};
    }
}

/// A hull of random points, all of them above z = 0, one of them at it.
Shape hull_above(CaseNumbers& draw)
{
    ConvexHull hull;
    for (int k = draw.number(6, 20); k > 0; --k) hull.points.push_back(draw.vector());
    double least = 1;
    for (const Vector3d& p : hull.points) least = std::min(least, p.z());
    for (Vector3d& p : hull.points) p.z() -= least;
    return hull;
}

/// A box of a broad phase, all of whose numbers are exact in float.
LeagueBody eighths_box(const Vector3d& middle, const Vector3d& half)
{
    return placed(Box{half / 8}, middle / 8);
}

LeagueCase box_and_cells(CaseNumbers& draw)
{
    std::vector<MapCell> cells;
    for (int k = draw.number(1, 30); k > 0; --k)
        cells.push_back({draw.number(-10, 10), draw.number(-10, 10), draw.number(-10, 10), 1});
    const Vector3d half(draw.real(0.1, 1), draw.real(0.1, 1), draw.real(0.1, 1));
    const double resolution = std::ldexp(1.0, draw.number(-5, 0));
    return {.a = {make_occupancy_map("map", resolution, cells)},
            .b = placed(Box{half}, draw.real(5, 20) * draw.vector().normalized(), turn_or_none(draw))};
}

/// An edge of each box is nearest to the other box, and the two are almost parallel.
LeagueCase edges_face_each_other(CaseNumbers& draw)
{
    const double a = draw.real(0.2, 2), b = draw.real(0.2, 2), gap = draw.magnitude(-10, 0);
    const Matrix3d on_edge = turn_by(std::numbers::pi / 4, Vector3d::UnitX());
    const Matrix3d twist = about_z(draw.one_in(4) ? 0 : draw.sign() * draw.magnitude(-50, -3));
    const double up = std::numbers::sqrt2 * (a + b) + gap;
    return turned_together(
        {.a = placed(Box{{draw.real(0.5, 5), a, a}}, Vector3d::Zero(), on_edge),
         .b = placed(Box{{draw.real(0.5, 5), b, b}}, {draw.real(-0.4, 0.4), 0, up}, twist * on_edge)},
        turn_or_none(draw));
}

LeagueCase kissing_boxes(CaseNumbers& draw)
{
    const auto half = [&] { return Vector3d(draw.real(0.1, 2), draw.real(0.1, 2), draw.real(0.1, 2)); };
    const Vector3d a = half(), b = draw.one_in(3) ? a : half();
    const double deep = draw.one_in(5) ? 0 : std::min(a.z(), b.z()) * draw.magnitude(-20, -3);
    const Vector3d by(draw.number(0, 1) * 0.5 * a.x(), draw.number(-1, 1) * 0.5 * a.y(), a.z() + b.z() - deep);
    const Matrix3d turn = draw.number(0, 1) ? about_z(draw.magnitude(-40, -4)) : Matrix3d::Identity();
    return turned_together({.a = placed(Box{a}), .b = placed(Box{b}, by, turn)}, turn_or_none(draw));
}

LeagueCase slab_and_cylinder(CaseNumbers& draw)
{
    const double radius = draw.real(0.1, 1), half = draw.real(0.1, 2), thick = draw.real(0.01, 0.5);
    const double gap = draw.sign() * draw.magnitude(-8, -3);
    const Vector3d place = draw.number(0, 1) ? Vector3d(Vector3d::Zero()) : 60 * whole_point(draw, 1);
    const bool lies = draw.number(0, 1);
    return {.a = placed(Cylinder{radius, 2 * half}, place + Vector3d(0, 0, thick + (lies ? radius : half) + gap),
                        lies ? turn_by(std::numbers::pi / 2, Vector3d::UnitX()) : Matrix3d::Identity()),
            .b = placed(Box{{10, 10, thick}}, place + Vector3d(draw.real(-5, 5), draw.real(-5, 5), 0))};
}

LeagueCase capsule_over_box(CaseNumbers& draw)
{
    const double radius = draw.real(0.1, 1), length = draw.real(0.1, 2), height = draw.real(0.1, 2);
    const bool lies = draw.number(0, 1);
    const double gap = draw.one_in(3) ? 0 : draw.one_in(2) ? 0.01 : draw.magnitude(-14, 1);
    const Vector3d at(draw.real(-1, 1), draw.real(-1, 1), height + radius + (lies ? 0 : length / 2) + gap);
    return turned_together(
        {.a = placed(Box{{draw.real(1, 5), draw.real(1, 5), height}}),
         .b = placed(Capsule{radius, length}, at,
                     lies ? turn_by(std::numbers::pi / 2, Vector3d::UnitY()) : Matrix3d::Identity())},
        turn_or_none(draw));
}

LeagueCase cylinder_over_plane(CaseNumbers& draw)
{
    const double radius = draw.real(0.05, 1), half = draw.real(0.05, 1);
    const double tilt = draw.number(0, 2) * std::numbers::pi / 4, gap = draw.magnitude(-10, 1);
    const double reach = radius * std::abs(std::sin(tilt)) + half * std::abs(std::cos(tilt));
    const Vector3d at(draw.real(-3, 3), draw.real(-3, 3), reach + gap);
    return turned_together(
        {.a = placed(HalfSpace{}),
         .b = placed(Cylinder{radius, 2 * half}, at, about_z(draw.real(0, 6)) * turn_by(tilt, Vector3d::UnitX()))},
        turn_or_none(draw));
}

LeagueCase trapezoid_on_box(CaseNumbers& draw)
{
    const double height = draw.real(0.1, 1), bottom = draw.real(0.2, 2), thick = draw.real(0.1, 1);
    const double deep = draw.one_in(3) ? 0 : height * draw.magnitude(-20, -5);
    const Shape prism = trapezoid(bottom, draw.real(0.1, 2), height, draw.real(0.2, 2));
    return turned_together({.a = placed(Box{{3, 3, thick}}),
                            .b = placed(prism, {draw.real(-1, 1), draw.real(-1, 1), thick + height - deep},
                                        about_z(draw.number(0, 3) * draw.real(0, 1)))},
                           turn_or_none(draw));
}

/// The tip of the cone b is in a: b is at least as deep as its tip, and the depth that was found is an upper bound.
LeagueTruth tip_deep(const LeagueCase& asked)
{
    LeagueTruth truth = truths::shapes_deep(asked);
    const Vector3d origin = asked.b.pose.translation();
    const oracle::SolidTruth slab(std::get<Shape>(asked.a.geometry), asked.a.pose, origin);
    const long double half = std::get<Cone>(std::get<Shape>(asked.b.geometry)).length / 2.0L;
    const oracle::LongVector tip = half * asked.b.pose.linear().col(2).cast<long double>();
    truth.lower = std::clamp(-slab.from_surface(tip), 0.0L, truth.upper);
    return truth;
}

std::vector<LeagueFamily> depth_reports()
{
    return {report_family(
                "small ball deep in a box, mujoco#2206", depth, "A ball is inside a box that is many times larger.",
                [](CaseNumbers& draw) {
                    const Vector3d half(draw.real(0.2, 2), draw.real(0.2, 2), draw.real(0.2, 2));
                    const Vector3d at = draw.one_in(5) ? Vector3d(Vector3d::Zero()) : half.cwiseProduct(draw.vector());
                    return turned_together({.a = placed(Box{half}), .b = placed(Sphere{draw.real(5e-3, 0.05)}, at)},
                                           turn_or_none(draw));
                }),
            report_family("kissing boxes, fcl#415", depth,
                          "The faces of two boxes touch or overlap by little, and are parallel or nearly parallel.",
                          kissing_boxes),
            report_family("cone with its tip in a slab, reactphysics3d#2",
                          {LEAGUE_DEPTH, tip_deep, truths::gap_confirmed},
                          "The tip of a cone is a millionth to nine tenths of a metre deep in a slab.",
                          [](CaseNumbers& draw) {
                              const double half = draw.real(0.5, 2), deep = draw.magnitude(-20, 0) * 0.9;
                              const Vector3d at(draw.real(-2, 2), draw.real(-2, 2), 1 + half - deep);
                              return LeagueCase{.a = placed(Box{{5, 5, 1}}),
                                                .b = placed(Cone{draw.real(0.1, 2), 2 * half}, at,
                                                            Vector3d(1, -1, -1).asDiagonal().toDenseMatrix())};
                          }),
            report_family("trapezoid that touches a box, fcl#503", depth,
                          "A prism over a trapezoid stands on a box, or is a little deep in it.", trapezoid_on_box)};
}

std::vector<LeagueFamily> distance_reports()
{
    return {
        report_family("capsule 1 cm above a box, parry#378", distance,
                      "A capsule lies or stands over a box, at a touch or with a small gap.", capsule_over_box),
        report_family("nearest points of round bodies and a box, fcl#127", distance,
                      "A ball or a cylinder is beside a box, in any direction.",
                      [](CaseNumbers& draw) {
                          const double r = draw.real(0.1, 1);
                          const Vector3d half(draw.real(0.1, 1), draw.real(0.1, 1), draw.real(0.1, 1));
                          return LeagueCase{
                              .a = placed(draw.number(0, 1) ? Shape(Sphere{r}) : Shape(Cylinder{r, draw.real(0.1, 2)}),
                                          Vector3d::Zero(), draw.rotation()),
                              .b = placed(Box{half}, draw.real(2, 6) * draw.vector().normalized(), turn_or_none(draw))};
                      }),
        report_family("box beside the cells of a map, fcl#640", distance,
                      "A box is beside a few cells of an occupancy map.", box_and_cells),
        report_family("ball and an equal ellipsoid, coal#307", distance,
                      "A ball is beside an ellipsoid with three axes of the same length.",
                      [](CaseNumbers& draw) {
                          const double r = draw.real(0.1, 2), gap = draw.one_in(5) ? 0 : draw.magnitude(-12, 3);
                          return LeagueCase{.a = placed(Sphere{r}, draw.vector()),
                                            .b =
                                                placed(Ellipsoid{{r, r, r}}, (2 * r + gap) * draw.vector().normalized(),
                                                       turn_or_none(draw))};
                      }),
        report_family("shapes over a cube of triangles, mujoco_warp#1649", distance,
                      "A shape of one of six kinds stands over the face of a cube that is a mesh.",
                      [](CaseNumbers& draw) {
                          const auto [shape, reach] = upright_shape(draw);
                          const double gap = draw.one_in(5) ? 0 : draw.magnitude(-14, 0);
                          return LeagueCase{.a = {make_box_mesh({0.5, 0.5, 0.5})},
                                            .b = placed(shape,
                                                        {draw.real(-0.4, 0.4), draw.real(-0.4, 0.4), 0.5 + reach + gap},
                                                        about_z(draw.real(0, 6)))};
                      }),
        report_family("hulls that a plane parts, mujoco#3383", distance,
                      "Two hulls of random points are on either side of a plane.",
                      [](CaseNumbers& draw) {
                          const Shape a = hull_above(draw), b = hull_above(draw);
                          return turned_together(
                              {.a = placed(a, Vector3d::Zero(), Vector3d(1, -1, -1).asDiagonal().toDenseMatrix()),
                               .b = placed(b, {draw.real(-1, 1), draw.real(-1, 1), draw.magnitude(-10, 0)})},
                              turn_or_none(draw));
                      }),
        report_family("edges that are almost parallel, fcl#399", distance,
                      "The nearest edges of two boxes are parallel, or almost parallel.", edges_face_each_other),
        report_family("cylinder over a plane, newton#826", distance,
                      "A cylinder stands, lies or is tilted over a half-space.", cylinder_over_plane)};
}

std::vector<LeagueFamily> scene_reports()
{
    return {report_family("cylinder and slab, ncollide#157", meeting,
                          "A cylinder is just above a slab or a little deep in it, at the origin or 60 m away.",
                          slab_and_cylinder),
            report_family("all bodies in one place, PhysX#262", pairs, "All boxes are equal and in the same place.",
                          [](CaseNumbers& draw) {
                              LeagueCase asked;
                              const Vector3d middle = whole_point(draw, 800),
                                             half = whole_point(draw, 7) + Vector3d::Constant(8);
                              asked.bodies.assign(std::size_t(draw.number(2, 300)), eighths_box(middle, half));
                              return asked;
                          }),
            report_family("one huge body and many tiny ones, matter-js#351", pairs,
                          "One box of kilometres holds some of many boxes of less than a metre.",
                          [](CaseNumbers& draw) {
                              LeagueCase asked;
                              asked.bodies.push_back(eighths_box(Vector3d::Zero(), Vector3d::Constant(8192)));
                              for (int k = draw.number(100, 800); k > 0; --k)
                                  asked.bodies.push_back(
                                      eighths_box(whole_point(draw, draw.one_in(4) ? 40 : 10000),
                                                  Vector3d(draw.number(1, 4), draw.number(1, 4), draw.number(1, 4))));
                              return asked;
                          })};
}

} // namespace

LeagueFamily report_family(const char* situation, const ReportTruth& truth, std::string what,
                           std::function<LeagueCase(CaseNumbers&)> make)
{
    return {std::string("report: ") + situation,
            "reports",
            truth.question,
            std::move(what),
            [make = std::move(make), question = truth.question](std::uint64_t seed) {
                CaseNumbers draw(seed);
                LeagueCase asked = make(draw);
                asked.question = question;
                return asked;
            },
            truth.truth,
            truth.confirms ? decltype(LeagueFamily::confirms)(truth.confirms) : nullptr};
}

double touch_or_gap(CaseNumbers& draw, int low, int high)
{
    return draw.one_in(4) ? 0 : draw.sign() * draw.magnitude(low, high);
}

Vector3d whole_point(CaseNumbers& draw, int most)
{
    return Vector3d(draw.number(-most, most), draw.number(-most, most), draw.number(-most, most));
}

Matrix3d turn_or_none(CaseNumbers& draw)
{
    return draw.number(0, 1) ? draw.rotation() : Matrix3d::Identity();
}

LeagueBody placed(Shape shape, const Vector3d& at, const Matrix3d& turn)
{
    LeagueBody body{std::move(shape)};
    body.pose.translation() = at, body.pose.linear() = turn;
    return body;
}

LeagueCase turned_together(LeagueCase asked, const Matrix3d& turn)
{
    for (LeagueBody* body : {&asked.a, &asked.b}) {
        body->pose.linear() = turn * body->pose.linear();
        body->pose.translation() = turn * body->pose.translation();
    }
    asked.motion = turn * asked.motion;
    return asked;
}

std::vector<LeagueFamily> report_league()
{
    std::vector<LeagueFamily> all;
    for (auto* part : {depth_reports, distance_reports, scene_reports})
        for (LeagueFamily& family : part()) all.push_back(std::move(family));
    return all;
}

} // namespace oncollide::tools
