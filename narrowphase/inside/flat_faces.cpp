#include <oncollide/narrowphase/inside/flat_faces.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <tuple>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/inside/cut_polygon.hpp>

namespace oncollide {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr std::uint32_t nothing = MeshLinks::none;
constexpr std::size_t most_corners = 1000; ///< most corners of a polygon

/// An edge of a polygon: the interior is to its left.
struct EdgeSide {
    std::uint32_t from, to, polygon;
};

class FaceJoiner {
public:
    FaceJoiner(const Mesh& mesh, const MeshLinks& links)
        : mesh_(mesh), links_(links), polygon_of_(mesh.triangles.size(), nothing),
          droppable_(mesh.vertices.size(), true)
    {
    }

    std::optional<FlatFaces> join()
    {
        for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t)
            if (polygon_of_[t] == nothing) collect(t);
        if (2 * first_.size() > mesh_.triangles.size()) return {};
        find_sides();
        // A polygon that stays as it is keeps its corners, so its neighbours must keep them, too.
        for (bool failed = true; failed;) {
            find_droppable();
            triangles_.clear(), face_.clear(), failed = false;
            for (std::uint32_t p = 0; p < first_.size(); ++p)
                if (!add(p)) whole_[p] = failed = true;
        }
        if (2 * triangles_.size() > mesh_.triangles.size()) return {};
        return result();
    }

private:
    const Vector3d& point(std::uint32_t v) const { return mesh_.vertices[v]; }
    std::uint32_t corner(std::uint32_t triangle, int k) const { return links_.vertex[mesh_.triangles[triangle][k]]; }
    TrianglePoints points(std::uint32_t t) const
    {
        return {point(corner(t, 0)), point(corner(t, 1)), point(corner(t, 2))};
    }

    /// Collects the triangles that are connected to one in its plane, on the same side.
    void collect(std::uint32_t first)
    {
        const auto number = static_cast<std::uint32_t>(first_.size());
        first_.push_back(first), members_.push_back({first}), polygon_of_[first] = number;
        const TrianglePoints plane = points(first);
        const bool flat = collinear(plane[0], plane[1], plane[2]);
        whole_.push_back(flat);
        if (flat) return;
        const Vector3d normal = (plane[1] - plane[0]).cross(plane[2] - plane[0]);
        for (std::size_t i = 0; i < members_[number].size(); ++i)
            for (const std::uint32_t t : links_.neighbours[members_[number][i]]) {
                if (t == nothing || polygon_of_[t] != nothing) continue;
                const TrianglePoints c = points(t);
                const bool inside = std::ranges::all_of(
                    c, [&](const Vector3d& p) { return orient3d(plane[0], plane[1], plane[2], p) == 0; });
                if (!inside || !(normal.dot((c[1] - c[0]).cross(c[2] - c[0])) > 0)) continue;
                polygon_of_[t] = number, members_[number].push_back(t);
            }
        whole_[number] = members_[number].size() == 1;
    }

    void find_sides()
    {
        for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t)
            for (int k = 0; k < 3; ++k) {
                const std::uint32_t beyond = links_.neighbours[t][k];
                if (beyond == nothing || polygon_of_[beyond] != polygon_of_[t])
                    sides_.push_back({corner(t, k), corner(t, (k + 1) % 3), polygon_of_[t]});
            }
        std::ranges::sort(sides_, {}, [](const EdgeSide& s) { return std::tuple(s.polygon, s.from, s.to); });
        offsets_.assign(first_.size() + 1, 0);
        for (const EdgeSide& s : sides_) ++offsets_[s.polygon + 1];
        for (std::size_t p = 0; p < first_.size(); ++p) offsets_[p + 1] += offsets_[p];
    }
    std::span<const EdgeSide> sides(std::uint32_t polygon) const
    {
        return std::span(sides_).subspan(offsets_[polygon], offsets_[polygon + 1] - offsets_[polygon]);
    }
    /// A corner may be dropped if it is on a straight edge of one polygon, or of both polygons beside the edge.
    void find_droppable()
    {
        // The corners before and after each vertex.
        std::vector<std::array<std::uint32_t, 2>> beside(mesh_.vertices.size(), {nothing, nothing});
        for (const EdgeSide& s : sides_) {
            for (const auto& [v, other] : {std::pair(s.from, s.to), std::pair(s.to, s.from)}) {
                auto& [one, two] = beside[v];
                if (one == other || two == other) continue;
                if (one == nothing)
                    one = other;
                else if (two == nothing)
                    two = other;
                else
                    droppable_[v] = false;
            }
            if (whole_[s.polygon]) droppable_[s.from] = droppable_[s.to] = false;
        }
        for (std::uint32_t p = 0; p < first_.size(); ++p)
            if (whole_[p])
                for (const std::uint32_t t : members_[p])
                    for (int k = 0; k < 3; ++k) droppable_[corner(t, k)] = false;
        for (std::uint32_t v = 0; v < mesh_.vertices.size(); ++v) {
            const auto [one, two] = beside[v];
            if (one == nothing) continue;
            droppable_[v] = droppable_[v] && two != nothing && collinear(point(one), point(v), point(two)) &&
                            (point(one) - point(v)).dot(point(two) - point(v)) < 0;
        }
    }

    /// The loops around a polygon, made of the corners that are left; none if there are too many corners, or if the
    /// polygon touches itself at one.
    std::optional<std::vector<std::vector<std::uint32_t>>> loops_of(std::uint32_t polygon) const
    {
        const auto own = sides(polygon);
        for (std::size_t i = 1; i < own.size(); ++i)
            if (own[i].from == own[i - 1].from) return {};
        std::vector<bool> used(own.size(), false);
        std::vector<std::vector<std::uint32_t>> loops;
        std::size_t corners = 0;
        for (std::size_t i = 0; i < own.size(); ++i) {
            if (used[i]) continue;
            auto& loop = loops.emplace_back();
            for (std::size_t at = i; !used[at];) {
                used[at] = true;
                if (!droppable_[own[at].from]) loop.push_back(own[at].from);
                const auto next = std::ranges::lower_bound(own, own[at].to, {}, &EdgeSide::from);
                if (next == own.end() || next->from != own[at].to) return {};
                at = static_cast<std::size_t>(next - own.begin());
            }
            corners += loop.size();
            if (loop.size() < 3 || corners > most_corners) return {};
        }
        return loops;
    }

    /// Adds the triangles of a polygon; false if it cannot be cut.
    bool add(std::uint32_t polygon)
    {
        const auto& members = members_[polygon];
        if (whole_[polygon]) {
            for (const std::uint32_t t : members)
                triangles_.push_back({corner(t, 0), corner(t, 1), corner(t, 2)}), face_.push_back(t);
            return true;
        }
        auto loops = loops_of(polygon);
        if (!loops) return false;
        // Points are projected onto the plane of two axes, as seen from outside.
        const TrianglePoints plane = points(first_[polygon]);
        const Vector3d normal = (plane[1] - plane[0]).cross(plane[2] - plane[0]);
        int axis = 0;
        normal.cwiseAbs().maxCoeff(&axis);
        int x = (axis + 1) % 3, y = (axis + 2) % 3;
        if (normal[axis] < 0) std::swap(x, y);
        std::vector<Vector2d> flat;
        std::vector<std::uint32_t> number;
        for (auto& loop : *loops)
            for (std::uint32_t& v : loop) {
                flat.emplace_back(point(v)[x], point(v)[y]), number.push_back(v);
                v = static_cast<std::uint32_t>(flat.size() - 1);
            }
        const auto cut = cut_polygon(flat, std::move(*loops));
        if (!cut || !has_area(*cut, members, flat, x, y)) return false;
        for (const auto& [a, b, c] : *cut)
            triangles_.push_back({number[a], number[b], number[c]}), face_.push_back(first_[polygon]);
        return true;
    }
    /// True if the triangles have as much area as the members: false for a polygon that covers itself.
    bool has_area(const std::vector<Triangle>& cut, const std::vector<std::uint32_t>& members,
                  const std::vector<Vector2d>& flat, int x, int y) const
    {
        const auto twice = [](const Vector2d& a, const Vector2d& b, const Vector2d& c) {
            return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
        };
        double now = 0, before = 0;
        for (const auto& [a, b, c] : cut) now += twice(flat[a], flat[b], flat[c]);
        for (const std::uint32_t t : members) {
            const TrianglePoints p = points(t);
            before += twice({p[0][x], p[0][y]}, {p[1][x], p[1][y]}, {p[2][x], p[2][y]});
        }
        return std::abs(now - before) <= 1e-9 * before;
    }

    FlatFaces result()
    {
        FlatFaces out;
        std::vector<std::uint32_t> number(mesh_.vertices.size(), nothing);
        for (Triangle& t : triangles_)
            for (std::uint32_t& v : t) {
                if (number[v] == nothing) {
                    number[v] = static_cast<std::uint32_t>(out.vertex.size());
                    out.vertex.push_back(v), out.mesh.vertices.push_back(point(v)), out.mesh.bounds.add(point(v));
                }
                v = number[v];
            }
        out.mesh.triangles = std::move(triangles_), out.face = std::move(face_);
        return out;
    }

    const Mesh& mesh_;
    const MeshLinks& links_;
    std::vector<std::uint32_t> polygon_of_;           ///< polygon of each triangle
    std::vector<std::uint32_t> first_;                ///< for each polygon: its first triangle
    std::vector<std::vector<std::uint32_t>> members_; ///< its triangles
    std::vector<bool> whole_;                         ///< it stays as it is
    std::vector<EdgeSide> sides_;                     ///< by polygon
    std::vector<std::size_t> offsets_;
    std::vector<bool> droppable_; ///< true for each vertex that may be dropped
    std::vector<Triangle> triangles_;
    std::vector<std::uint32_t> face_;
};

} // namespace

std::optional<FlatFaces> join_flat_faces(const Mesh& mesh, const MeshLinks& links)
{
    return FaceJoiner(mesh, links).join();
}

} // namespace oncollide
