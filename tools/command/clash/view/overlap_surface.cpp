#include "clash/view/overlap_surface.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include <oncollide/narrowphase/inside/point_location.hpp>
#include <oncollide/narrowphase/obb/obb_tree.hpp>

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;
using TriangleCorners = std::array<Vector3d, 3>;
using Segment = std::array<Vector3d, 2>;
using Polygon = std::vector<Vector3d>; ///< convex, flat

TriangleCorners corners_of(const PlacedMesh& placed, std::uint32_t triangle)
{
    const Triangle& t = placed.mesh.triangles[triangle];
    return {placed.pose * placed.mesh.vertices[t[0]], placed.pose * placed.mesh.vertices[t[1]],
            placed.pose * placed.mesh.vertices[t[2]]};
}

/// Twice the area, along the normal.
Vector3d area_of(std::span<const Vector3d> polygon)
{
    Vector3d area = Vector3d::Zero();
    for (std::size_t k = 2; k < polygon.size(); ++k)
        area += (polygon[k - 1] - polygon[0]).cross(polygon[k] - polygon[0]);
    return area;
}

Vector3d middle_of(std::span<const Vector3d> polygon)
{
    return std::accumulate(polygon.begin(), polygon.end(), Vector3d(Vector3d::Zero())) / double(polygon.size());
}

/// Locates points in a mesh.
class Located {
public:
    explicit Located(const PlacedMesh& placed)
        : placed_(placed), tree_(placed.mesh), into_(Eigen::Isometry3d::Identity(), placed.pose)
    {
    }
    bool inside(const Vector3d& point)
    {
        return locator_.place(point, placed_.mesh, &tree_, into_) == PointLocation::inside;
    }

private:
    const PlacedMesh& placed_;
    ObbTree tree_;
    RelativePose into_;
    PointLocator locator_;
};

/// Cuts the polygon along the segment's line if part of the segment lies within it; returns the part to the left, and
/// leaves the part to the right. Empty: not cut.
Polygon cut_off(Polygon& polygon, const Segment& segment, const Vector3d& normal)
{
    const Vector3d along = segment[1] - segment[0];
    const double length = along.norm();
    if (!(length > 0)) return {};
    const Vector3d left = normal.cross(along / length);
    std::vector<double> side;
    double size = 0;
    for (const Vector3d& p : polygon)
        side.push_back(left.dot(p - segment[0])), size = std::max(size, std::abs(side.back()));
    const double rounding = 0x1p-36 * (size + length);
    if (std::ranges::none_of(side, [&](double s) { return s > rounding; }) ||
        std::ranges::none_of(side, [&](double s) { return s < -rounding; }))
        return {};
    Polygon parts[2];
    std::array<double, 2> within{length, 0}; // the line within the polygon, as positions along the segment
    for (std::size_t k = 0; k < polygon.size(); ++k) {
        const std::size_t next = (k + 1) % polygon.size();
        const bool on = std::abs(side[k]) <= rounding;
        const auto cross = [&](const Vector3d& p) {
            const double at = along.dot(p - segment[0]) / length;
            within = {std::min(within[0], at), std::max(within[1], at)};
        };
        for (const bool right : {false, true})
            if (on || (side[k] < 0) == right) parts[right].push_back(polygon[k]);
        if (on) cross(polygon[k]);
        if (on || std::abs(side[next]) <= rounding || (side[k] < 0) == (side[next] < 0)) continue;
        const Vector3d p = polygon[k] + side[k] / (side[k] - side[next]) * (polygon[next] - polygon[k]);
        cross(p);
        for (Polygon& part : parts) part.push_back(p);
    }
    if (std::min(within[1], length) - std::max(within[0], 0.0) <= rounding) return {};
    polygon = std::move(parts[1]);
    return std::move(parts[0]);
}

/// One of the two meshes, whose faces inside the other are wanted.
class CutMesh {
public:
    CutMesh(const PlacedMesh& own, const PlacedMesh& other, double depth)
        : own_(own), other_(other), located_(other), depth_(depth), lines_(own.mesh.triangles.size())
    {
        for (const Vector3d& v : other.mesh.vertices) box_.add(other.pose * v);
        double volume = 0;
        for (const Triangle& t : own.mesh.triangles)
            volume += (own.mesh.vertices[t[0]] - own.mesh.bounds.centre())
                          .dot((own.mesh.vertices[t[1]] - own.mesh.bounds.centre())
                                   .cross(own.mesh.vertices[t[2]] - own.mesh.bounds.centre()));
        outward_ = volume < 0 ? -1 : 1;
    }

    /// Adds a segment of a face along which a face of the other mesh meets it. For coplanar faces any common segment is
    /// enough: another face meets them where one of them ends.
    void add(std::uint32_t face, const Segment& segment) { lines_[face].push_back(segment); }

    /// Appends the faces inside the other mesh. False if there are more than `most` triangles.
    bool add_inside(std::vector<TriangleCorners>& triangles, std::size_t most)
    {
        join_uncut();
        std::vector<std::int8_t> inside(own_.mesh.vertices.size(), -1); // by set of faces
        for (std::uint32_t face = 0; face < lines_.size(); ++face) {
            const TriangleCorners corners = corners_of(own_, face);
            if (!near(corners) || !(area_of(corners).norm() > 0)) continue;
            if (lines_[face].empty()) {
                std::int8_t& known = inside[set_of(own_.mesh.triangles[face][0])];
                if (known < 0) known = is_inside(corners);
                if (known) triangles.push_back(corners);
            } else
                add_pieces(face, corners, triangles, most);
            if (triangles.size() > most) return false;
        }
        return true;
    }

private:
    bool near(const TriangleCorners& corners) const
    {
        Aabb face;
        for (const Vector3d& p : corners) face.add(p);
        return (face.min.array() <= box_.max.array()).all() && (face.max.array() >= box_.min.array()).all();
    }

    /// Joins the vertices of faces that the other mesh does not meet: all are on one side of it.
    void join_uncut()
    {
        sets_.resize(own_.mesh.vertices.size());
        std::iota(sets_.begin(), sets_.end(), 0u);
        for (std::size_t face = 0; face < lines_.size(); ++face)
            if (const Triangle& t = own_.mesh.triangles[face]; lines_[face].empty())
                sets_[set_of(t[1])] = set_of(t[0]), sets_[set_of(t[2])] = set_of(t[0]);
    }
    std::uint32_t set_of(std::uint32_t vertex)
    {
        while (sets_[vertex] != vertex) vertex = sets_[vertex] = sets_[sets_[vertex]];
        return vertex;
    }

    /// True if the part of the own solid just below the polygon is inside the other mesh. Below, because coplanar faces
    /// belong to the common part's surface if both solids are on the same side of them.
    bool is_inside(std::span<const Vector3d> polygon)
    {
        const Vector3d area = area_of(polygon);
        const double size = std::sqrt(area.norm());
        return located_.inside(middle_of(polygon) -
                               outward_ * std::min(0.01 * depth_, 0.01 * size) * area.normalized());
    }

    void add_pieces(std::uint32_t face, const TriangleCorners& corners, std::vector<TriangleCorners>& triangles,
                    std::size_t most)
    {
        const Vector3d area = area_of(corners), normal = area.normalized();
        std::vector<Polygon> pieces{Polygon(corners.begin(), corners.end())};
        for (const Segment& segment : lines_[face])
            for (std::size_t k = 0, count = pieces.size(); k < count; ++k)
                if (Polygon left = cut_off(pieces[k], segment, normal); !left.empty()) {
                    pieces.push_back(std::move(left));
                    if (pieces.size() > most) return;
                }
        for (const Polygon& piece : pieces) {
            if (area_of(piece).norm() < 1e-12 * area.norm() || !is_inside(piece)) continue;
            for (std::size_t k = 2; k < piece.size(); ++k) triangles.push_back({piece[0], piece[k - 1], piece[k]});
        }
    }

    PlacedMesh own_, other_;
    Located located_;
    double depth_, outward_ = 1;
    Aabb box_;
    std::vector<std::vector<Segment>> lines_; ///< by face
    std::vector<std::uint32_t> sets_;         ///< of vertices
};

} // namespace

std::vector<std::array<Vector3d, 3>> overlap_surface(const PlacedMesh& a, const PlacedMesh& b,
                                                     const std::vector<Contact>& contacts, double depth,
                                                     std::size_t most)
{
    CutMesh side_a(a, b, depth), side_b(b, a, depth);
    for (const Contact& contact : contacts) {
        side_a.add(contact.a.triangle, contact.ends);
        side_b.add(contact.b.triangle, contact.ends);
    }
    std::vector<TriangleCorners> triangles;
    if (!side_a.add_inside(triangles, most) || !side_b.add_inside(triangles, most)) triangles.clear();
    return triangles;
}

} // namespace oncollide::tools
