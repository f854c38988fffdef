#include "verify/cases/drawn_shapes.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include <oncollide/samples/generators.hpp>

#include "verify/cases/case_numbers.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using oracle::LongVector;
using oracle::SolidTruth;

class ShapeNumbers : public CaseNumbers {
public:
    using CaseNumbers::CaseNumbers;

    /// One of the 24 rotations that keep the axes.
    Matrix3d quarter_turns()
    {
        std::array<int, 3> axes{0, 1, 2};
        for (int k = 2; k > 0; --k) std::swap(axes[k], axes[number(0, k)]);
        Matrix3d turn = Matrix3d::Zero();
        for (int k = 0; k < 3; ++k) turn(k, axes[k]) = sign();
        if (turn.determinant() < 0) turn.row(2) *= -1;
        return turn;
    }
    Matrix3d slight_turn()
    {
        return Eigen::AngleAxisd(magnitude(-40, -10), Vector3d(vector() + Vector3d::Constant(1e-3)).normalized())
            .toRotationMatrix();
    }
};

/// Lengths of a shape: on a grid of 1/8 of its size or not, and with one or two of them thin.
class FormNumbers {
public:
    FormNumbers(ShapeNumbers& draw, double size) : draw_(draw), size_(size), grid_(draw.number(0, 1))
    {
        if (!draw.one_in(5)) return;
        const double thin = draw.magnitude(-20, -3);
        if (draw.number(0, 1))
            thin_.z() = thin;
        else
            thin_.x() = thin_.y() = thin;
    }
    double length(int k) { return size_ * thin_[k] * (grid_ ? 0.125 * draw_.number(1, 8) : draw_.real(0.05, 1)); }
    Vector3d lengths() { return {length(0), length(1), length(2)}; }
    Vector3d point()
    {
        const Vector3d p =
            grid_ ? 0.125 * Vector3d(draw_.number(-8, 8), draw_.number(-8, 8), draw_.number(-8, 8)) : draw_.vector();
        return size_ * p.cwiseProduct(thin_);
    }
    ConvexHull hull()
    {
        for (;;) {
            ConvexHull hull;
            const int count = draw_.one_in(8) ? draw_.number(12, 20) : draw_.number(4, 10);
            for (int k = 0; k < count; ++k) hull.points.push_back(point());
            if (draw_.one_in(4)) hull.points.push_back(hull.points[0]);
            try {
                check_shape("hull", hull);
                return hull;
            } catch (const Error&) { // flat
                thin_ = (2 * thin_).cwiseMin(1.0);
            }
        }
    }

private:
    ShapeNumbers& draw_;
    double size_;
    bool grid_;
    Vector3d thin_{1, 1, 1};
};

Shape draw_form_of(ShapeKind kind, double size, ShapeNumbers& draw)
{
    FormNumbers form(draw, size);
    switch (kind) {
    case ShapeKind::sphere:
        return Sphere{size * 0.125 * draw.number(1, 8)};
    case ShapeKind::capsule:
        return Capsule{form.length(0), draw.one_in(20) ? 0 : form.length(2)};
    case ShapeKind::box:
        return Box{form.lengths()};
    case ShapeKind::hull:
        return form.hull();
    case ShapeKind::cylinder:
        return Cylinder{form.length(0), form.length(2)};
    case ShapeKind::cone:
        return Cone{form.length(0), form.length(2)};
    case ShapeKind::ellipsoid: {
        const Vector3d axes = form.lengths();
        if (draw.one_in(4)) return Ellipsoid{{axes.x(), axes.x(), axes.z()}};
        return Ellipsoid{axes};
    }
    case ShapeKind::half_space:
        break;
    }
    return HalfSpace{};
}

/// A unit direction in the shape's frame: mostly across a face, an edge or a corner.
Vector3d feature_direction(const Shape& shape, ShapeNumbers& draw)
{
    if (std::holds_alternative<HalfSpace>(shape)) return Vector3d::UnitZ();
    const int style = draw.number(0, 5);
    if (style == 0) return (draw.vector() + Vector3d(0, 0, 1e-3)).normalized();
    if (const auto* cone = std::get_if<Cone>(&shape); cone && style < 3) {
        const double turn = draw.number(0, 1) ? 0 : draw.real(0, 6);
        const Vector3d slant(cone->length * std::cos(turn), cone->length * std::sin(turn), cone->radius);
        return slant.normalized();
    }
    if (const auto* hull = std::get_if<ConvexHull>(&shape); hull && style < 5) {
        const auto pick = [&] { return hull->points[std::size_t(draw.number(0, int(hull->points.size()) - 1))]; };
        const Vector3d at = pick(), n = (pick() - at).cross(pick() - at);
        if (n.norm() > 0 && n.allFinite()) return draw.sign() * n.normalized();
    }
    for (;;) {
        Vector3d signs(draw.number(-1, 1), draw.number(-1, 1), draw.number(-1, 1));
        if (style < 3) signs = draw.sign() * Vector3d::Unit(draw.number(0, 2)); // a face
        if (!signs.isZero()) return signs.normalized();
    }
}

double extent_of(const Shape& shape)
{
    return double(SolidTruth(shape, Isometry3d::Identity(), Vector3d::Zero()).size());
}

/// Draws two rotations. Returns the name of their style.
const char* draw_turns(Matrix3d& a, Matrix3d& b, ShapeNumbers& draw)
{
    a = draw.number(0, 1) ? Matrix3d::Identity() : draw.quarter_turns();
    b = draw.number(0, 1) ? a : draw.quarter_turns();
    switch (draw.number(0, 5)) {
    case 0:
    case 1:
        return "aligned";
    case 2: {
        const Matrix3d turn = draw.rotation();
        a = turn * a, b = turn * b;
        return "tilted alike";
    }
    case 3:
        b = draw.rotation();
        return "tilted";
    case 4:
        a = draw.rotation(), b = draw.rotation();
        return "free";
    default: {
        if (draw.number(0, 1)) a = draw.rotation();
        b = a * (draw.number(0, 1) ? Matrix3d::Identity() : draw.quarter_turns()) * draw.slight_turn();
        return "nearly parallel";
    }
    }
}

struct GapStyle {
    double gap, margin;
    const char* name;
};

/// @param size  of the smaller body
GapStyle draw_gap(double size, ShapeNumbers& draw)
{
    const double margin = draw.number(0, 1) ? 0 : size * draw.magnitude(-20, -1);
    switch (draw.number(0, 9)) {
    case 0:
    case 1:
        return {0, margin, "at rest"};
    case 2:
        return {size * 0x1p-52 * draw.number(-4, 4), margin, "at rest, some ulp"};
    case 3:
        return {size * draw.magnitude(-48, -20), margin, "a small gap"};
    case 4:
        return {-size * draw.magnitude(-48, -20), margin, "shallow"};
    case 5:
        return {margin * draw.real(0, 1), margin, "within the margin"};
    case 6:
        return {margin + size * draw.magnitude(-30, 0), margin, "beyond the margin"};
    case 7:
        return {margin * (1 + draw.sign() * draw.magnitude(-30, -5)), margin, "about the margin"};
    default:
        return {-size * draw.magnitude(-10, -1), margin, "pressed"};
    }
}

Vector3d far_away(ShapeNumbers& draw)
{
    if (!draw.one_in(4)) return Vector3d::Zero();
    const double way = draw.magnitude(0, 30);
    return draw.number(0, 1) ? Vector3d(way * draw.vector())
                             : Vector3d(std::ldexp(1.0, std::ilogb(way)) * Vector3d(draw.number(-3, 3), 1, 2));
}

Isometry3d pose_of(const Matrix3d& turn, const Vector3d& at)
{
    Isometry3d pose = Isometry3d::Identity();
    pose.linear() = turn, pose.translation() = at;
    return pose;
}

/// The point of a solid that is extreme along u.
LongVector top_along(const SolidTruth& solid, const Vector3d& u)
{
    const LongVector n = u.cast<long double>();
    return solid.is_half_space() ? solid.centre() : LongVector(solid.core_support(n) + solid.radius() * n);
}

} // namespace

ShapePair draw_shape_pair(ShapeKind kind_a, ShapeKind kind_b, std::uint64_t seed)
{
    ShapeNumbers draw(seed);
    const bool one_plane = kind_a == ShapeKind::half_space || kind_b == ShapeKind::half_space;
    const int placement = draw.number(0, one_plane ? 7 : 11); // 8 and 9: deep, 10 and 11: enclosed
    const bool enclosed = placement > 9;
    double ratio = draw.one_in(5) ? draw.magnitude(-20, 20) : 1;
    if (enclosed) ratio = draw.number(0, 1) ? draw.real(0.02, 0.3) : draw.real(3, 50);
    const double unit = draw.one_in(6) ? draw.magnitude(-12, 12) : 1;
    const Shape a = draw_form_of(kind_a, unit, draw), b = draw_form_of(kind_b, unit * ratio, draw);
    Matrix3d turn_a, turn_b;
    const char* turns = draw_turns(turn_a, turn_b, draw);
    const double size_a = extent_of(a), size_b = extent_of(b);
    const double smaller = one_plane ? std::max(size_a, size_b) : std::min(size_a, size_b);
    GapStyle style = draw_gap(smaller, draw);
    const Vector3d away = far_away(draw);
    const Isometry3d pose_a = pose_of(turn_a, away);
    Vector3d at = away;
    if (placement > 7) {
        style.name = enclosed ? "enclosed" : "deep";
        if (!draw.one_in(5)) at += draw.real(0, 0.3) * (enclosed ? std::max(size_a, size_b) : smaller) * draw.vector();
    } else {
        const bool of_a = kind_a == ShapeKind::half_space || (kind_b != ShapeKind::half_space && draw.number(0, 1));
        const Vector3d u =
            of_a ? Vector3d(turn_a * feature_direction(a, draw)) : Vector3d(-turn_b * feature_direction(b, draw));
        const SolidTruth solid_a(a, pose_a, away), solid_b(b, pose_of(turn_b, away), away);
        Vector3d aside = Vector3d::Zero();
        if (draw.number(0, 1)) {
            aside = 0.3 * (draw.number(0, 1) ? size_a : size_b) * draw.vector();
            aside -= u.dot(aside) * u;
        }
        const LongVector by = top_along(solid_a, u) - top_along(solid_b, -u);
        at = (away.cast<long double>() + by + (aside + style.gap * u).cast<long double>()).cast<double>();
    }
    return {a, b, pose_a, pose_of(turn_b, at), style.margin, fmt::format("{}, {}", style.name, turns)};
}

ShapeOnGround draw_shape_on_ground(ShapeKind kind, GroundKind ground_kind, std::uint64_t seed)
{
    ShapeNumbers draw(seed);
    ShapeOnGround drawn;
    const double unit = draw.one_in(5) ? draw.magnitude(-10, 3) : 1;
    drawn.shape = draw_form_of(kind, unit, draw);
    Matrix3d turn, unused;
    const char* turns = draw_turns(turn, unused, draw);
    const GapStyle style = draw_gap(extent_of(drawn.shape), draw);
    drawn.margin = style.margin;
    drawn.what = fmt::format("{}, {}", style.name, turns);
    const Vector3d away = far_away(draw);
    drawn.pose_ground = pose_of(draw.one_in(3) ? draw.rotation() : Matrix3d::Identity(), away);
    // The shape's lowest point is the gap above a point of the ground.
    Vector3d foot(draw.real(-1.5, 1.5), draw.real(-1.5, 1.5), 0);
    if (draw.number(0, 1)) foot = 0.25 * Vector3d(draw.number(-6, 6), draw.number(-6, 6), 0);
    std::vector<std::array<Vector3d, 3>> triangles;
    std::vector<std::pair<Vector3d, Vector3d>> blocks; // half-extents and centres
    drawn.may_be_below = ground_kind == GroundKind::terrain && style.gap < 0;
    if (ground_kind == GroundKind::mesh) {
        drawn.ground = make_box_mesh({3, 3, 1}), blocks = {{Vector3d(3, 3, 1), Vector3d::Zero()}};
        foot.z() = 1;
    } else if (ground_kind == GroundKind::map) {
        std::vector<MapCell> cells;
        for (int x = -2; x < 2; ++x)
            for (int y = -2; y < 2; ++y) cells.push_back({x, y, -1, 1});
        if (draw.number(0, 1)) cells.push_back({draw.number(-2, 1), draw.number(-2, 1), 0, 1});
        drawn.ground = make_occupancy_map("map", 1, cells);
        for (const MapCell& c : cells)
            blocks.emplace_back(Vector3d(0.5, 0.5, 0.5), Vector3d(c.x + 0.5, c.y + 0.5, c.z + 0.5));
    } else {
        const int count = 7;
        const double steep = draw.number(0, 1) ? 0 : 0.25;
        TerrainGrid grid{.columns = count, .rows = count, .origin = {-3, -3, 0}, .bytes = 8};
        std::vector<double> heights;
        for (int k = 0; k < count * count; ++k) heights.push_back(steep * draw.number(0, 2));
        const Terrain terrain = make_terrain("terrain", grid, heights);
        const Mesh mesh = mesh_of(terrain);
        for (const auto& [i, j, k] : mesh.triangles)
            triangles.push_back({mesh.vertices[i], mesh.vertices[j], mesh.vertices[k]});
        if (steep > 0) { // above a corner of the grid
            foot = Vector3d(std::round(foot.x()), std::round(foot.y()), 0);
            foot.z() = heights[std::size_t((foot.y() + 3) * count + foot.x() + 3)];
        }
        drawn.ground = terrain;
    }
    const SolidTruth local(drawn.shape, pose_of(turn, Vector3d::Zero()), Vector3d::Zero());
    const Vector3d at = foot - top_along(local, -Vector3d::UnitZ()).cast<double>() + style.gap * Vector3d::UnitZ();
    drawn.pose_shape = drawn.pose_ground * pose_of(turn, at);
    const Vector3d origin = drawn.pose_shape.translation();
    for (const auto& [half, centre] : blocks) {
        std::vector<Vector3d> corners;
        for (int k = 0; k < 8; ++k)
            corners.push_back(centre + half.cwiseProduct(Vector3d(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1)));
        drawn.parts.emplace_back(corners, drawn.pose_ground, origin);
    }
    for (const auto& t : triangles) drawn.parts.emplace_back(t, drawn.pose_ground, origin);
    return drawn;
}

} // namespace oncollide::tools
