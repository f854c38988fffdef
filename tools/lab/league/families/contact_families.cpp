// Contacts for simulations: shapes in each other, and faces that lie on each other.
#include <cmath>
#include <numbers>

#include "league/families/families.hpp"
#include "league/truths/truths.hpp"
#include "verify/cases/case_numbers.hpp"

#include <oncollide/samples/generators.hpp>

namespace oncollide::tools {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// The part of a convex polygon where normal * p <= height.
std::vector<Vector2d> clipped(const std::vector<Vector2d>& polygon, const Vector2d& normal, double height)
{
    std::vector<Vector2d> kept;
    for (std::size_t k = 0; k < polygon.size(); ++k) {
        const Vector2d &p = polygon[k], &q = polygon[(k + 1) % polygon.size()];
        const double at_p = normal.dot(p) - height, at_q = normal.dot(q) - height;
        if (at_p <= 0) kept.push_back(p);
        if ((at_p < 0) != (at_q < 0) && at_p != at_q) kept.push_back(p + at_p / (at_p - at_q) * (q - p));
    }
    return kept;
}

Vector2d centroid_of(const std::vector<Vector2d>& polygon)
{
    double area = 0;
    Vector2d sum = Vector2d::Zero();
    for (std::size_t k = 1; k + 1 < polygon.size(); ++k) {
        const Vector2d u = polygon[k] - polygon[0], v = polygon[k + 1] - polygon[0];
        const double twice = u.x() * v.y() - u.y() * v.x();
        area += twice, sum += twice * (polygon[0] + polygon[k] + polygon[k + 1]) / 3;
    }
    return sum / area;
}

enum class Ground { box, half_space, mesh, terrain, map };
const Vector3d ground_half{2, 3, 1};

/// The surface of the ground is z = 0 in x from -2 to 2 and y from -3 to 3.
struct Floor {
    GeometryData geometry;
    double below; ///< of the surface, the origin of the geometry
};

Floor floor_of(Ground ground)
{
    switch (ground) {
    case Ground::box:
        return {Shape(Box{ground_half}), ground_half.z()};
    case Ground::half_space:
        return {Shape(HalfSpace{}), 0};
    case Ground::mesh:
        return {make_box_mesh(ground_half), ground_half.z()};
    case Ground::terrain: {
        const TerrainGrid grid{.columns = 5, .rows = 7, .origin = {-2, -3, 0}, .bytes = 8};
        return {make_terrain("terrain", grid, std::vector<double>(35, 0)), 0};
    }
    case Ground::map:
        break;
    }
    std::vector<MapCell> cells;
    for (int x = -2; x < 2; ++x)
        for (int y = -3; y < 3; ++y) cells.push_back({x, y, -1, 1});
    return {make_occupancy_map("map", 1, cells), 0};
}

/// A shape whose lowest face, edge or point is horizontal.
struct Resting {
    GeometryData geometry{};
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    double height = 0;               ///< of its origin above its lowest point
    std::vector<Vector2d> corners{}; ///< of its lowest face, if a polygon
};

/// A prism on its base.
Resting prism_of(CaseNumbers& draw)
{
    Resting rests{.height = draw.real(0.1, 0.5)};
    const int sides = draw.number(3, 7);
    ConvexHull hull;
    for (int k = 0; k < sides; ++k) {
        const double angle = 2 * std::numbers::pi * (k + draw.real(-0.2, 0.2)) / sides;
        rests.corners.push_back(draw.real(0.2, 0.6) * Vector2d(std::cos(angle), std::sin(angle)));
    }
    // Corners that are within the others' polygon would be no corners of the face.
    for (std::size_t k = 0; k < rests.corners.size() && rests.corners.size() > 3;) {
        const std::size_t n = rests.corners.size();
        const Vector2d u = rests.corners[k] - rests.corners[(k + n - 1) % n],
                       v = rests.corners[(k + 1) % n] - rests.corners[k];
        if (u.x() * v.y() - u.y() * v.x() > 0.01)
            ++k;
        else
            rests.corners.erase(rests.corners.begin() + std::ptrdiff_t(k)), k = 0;
    }
    for (const Vector2d& c : rests.corners)
        for (const double z : {-rests.height, rests.height}) hull.points.emplace_back(c.x(), c.y(), z);
    rests.geometry = Shape(std::move(hull));
    return rests;
}

Resting resting_shape(CaseNumbers& draw, bool mesh)
{
    Resting rests;
    const double radius = draw.real(0.1, 0.6), half = draw.real(0.1, 0.6);
    switch (mesh ? 0 : draw.number(0, 5)) {
    case 0: {
        const Vector3d sides(draw.real(0.1, 1), draw.real(0.1, 1), half);
        rests.geometry = mesh ? GeometryData(make_box_mesh(sides)) : Shape(Box{sides});
        rests.height = half;
        for (const auto& [x, y] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}})
            rests.corners.emplace_back(x * sides.x(), y * sides.y());
        break;
    }
    case 1:
        rests.geometry = Shape(Cylinder{radius, 2 * half}), rests.height = half;
        break;
    case 2:
        rests.geometry = Shape(Cone{radius, 2 * half}), rests.height = half;
        break;
    case 3: // it lies
        rests.geometry = Shape(Capsule{radius, 2 * half}), rests.height = radius;
        rests.turn = Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitY()).toRotationMatrix();
        break;
    case 4:
        rests.geometry = Shape(Sphere{radius}), rests.height = radius;
        break;
    default:
        return prism_of(draw);
    }
    return rests;
}

LeagueCase rest_on(Ground ground, bool mesh, std::uint64_t seed)
{
    CaseNumbers draw(seed);
    const Floor floor = floor_of(ground);
    const Resting rests = resting_shape(draw, mesh);
    const Eigen::Rotation2Dd yaw(draw.one_in(3) ? 0 : draw.real(0, 6));
    Vector2d at(draw.real(-0.8, 0.8), draw.real(-1.8, 1.8)), centre = at;
    if (!rests.corners.empty()) {
        std::vector<Vector2d> area;
        for (const Vector2d& corner : rests.corners) area.push_back(at + yaw * corner);
        if (ground != Ground::half_space)
            for (int axis = 0; axis < 2; ++axis)
                for (const int sign : {-1, 1}) area = clipped(area, Vector2d::Unit(axis) * sign, ground_half[axis]);
        centre = centroid_of(area);
    }
    const double depth = draw.magnitude(-14, -6);
    Eigen::Isometry3d pose_a = Eigen::Isometry3d::Identity(), pose_b = pose_a, world = pose_a;
    if (!draw.one_in(3)) world.linear() = draw.rotation();
    if (draw.one_in(2)) world.translation() = 10 * draw.vector();
    pose_a.translation().z() = -floor.below;
    pose_b.linear() = Eigen::AngleAxisd(yaw.angle(), Vector3d::UnitZ()) * rests.turn;
    pose_b.translation() = Vector3d(at.x(), at.y(), rests.height - depth);
    return {.question = LEAGUE_CONTACTS,
            .a = {floor.geometry, world * pose_a, ground == Ground::mesh},
            .b = {rests.geometry, world * pose_b, mesh},
            .footprint = Footprint{world * Vector3d(centre.x(), centre.y(), -depth / 2), world.linear().col(2), depth}};
}

LeagueFamily rest_family(std::string name, Ground ground, bool mesh)
{
    return {"contacts: " + std::move(name),
            "contacts",
            LEAGUE_CONTACTS,
            "Bodies at rest, a face, an edge or a point 1e-4 to .02 m deep. Contacts must surround the middle of the "
            "common area, or "
            "the body tips.",
            [=](std::uint64_t seed) { return rest_on(ground, mesh, seed); },
            truths::contacts,
            truths::contacts_confirmed};
}

} // namespace

std::vector<LeagueFamily> contact_league()
{
    return {rest_family("shapes at rest on a box", Ground::box, false),
            rest_family("shapes at rest on a half-space", Ground::half_space, false),
            rest_family("shapes at rest on a mesh", Ground::mesh, false),
            rest_family("shapes at rest on a terrain", Ground::terrain, false),
            rest_family("shapes at rest on a map", Ground::map, false),
            rest_family("meshes at rest on a mesh", Ground::mesh, true)};
}

} // namespace oncollide::tools
