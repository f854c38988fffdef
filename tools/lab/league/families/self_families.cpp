// A mesh against itself. All vertices are integers, so that signs of volumes are exact in 64 bits.
#include <algorithm>
#include <array>
#include <cmath>

#include <oncollide/samples/generators.hpp>

#include "league/families/families.hpp"
#include "truth/exact_oracle.hpp"
#include "truth/exact_point.hpp"
#include "verify/cases/case_numbers.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;
using GridPoint = oracle::PointOf<std::int64_t>;

GridPoint grid_of(const Vector3d& p)
{
    return {std::int64_t(p.x()), std::int64_t(p.y()), std::int64_t(p.z())};
}

/// True if two triangles have a common point beyond the vertices that they share. With one shared vertex, the common
/// part of both is convex and holds the vertex; if it is larger, it reaches the opposite edge of one of them. With a
/// shared edge, it is larger only if both are in a plane, on one side of the edge.
bool meet_beyond(const Mesh& mesh, const Triangle& s, const Triangle& t)
{
    const auto at = [&](std::uint32_t v) { return mesh.vertices[v]; };
    const auto corners = [&](const Triangle& u) { return TrianglePoints{at(u[0]), at(u[1]), at(u[2])}; };
    const auto meet = [](const TrianglePoints& a, const TrianglePoints& b) {
        return oracle::contact(a, b) != TriangleContact::separate;
    };
    std::vector<std::uint32_t> shared, rest_s, rest_t;
    for (const std::uint32_t v : s) (std::ranges::find(t, v) != t.end() ? shared : rest_s).push_back(v);
    for (const std::uint32_t v : t)
        if (std::ranges::find(s, v) == s.end()) rest_t.push_back(v);
    if (shared.empty()) return meet(corners(s), corners(t));
    if (shared.size() == 1)
        return meet({at(rest_s[0]), at(rest_s[1]), at(rest_s[1])}, corners(t)) ||
               meet({at(rest_t[0]), at(rest_t[1]), at(rest_t[1])}, corners(s));
    if (shared.size() == 3) return true;
    const GridPoint u = grid_of(at(shared[0])), edge = grid_of(at(shared[1])) - u;
    const GridPoint to_s = cross(edge, grid_of(at(rest_s[0])) - u), to_t = cross(edge, grid_of(at(rest_t[0])) - u);
    return cross(to_s, to_t) == GridPoint{0, 0, 0} && dot(to_s, to_t) > 0;
}

LeagueTruth meets_itself(const LeagueCase& asked)
{
    const auto& mesh = std::get<Mesh>(asked.a.geometry);
    LeagueTruth truth{.meet = LeagueTruth::Meet::no, .exact = true, .size = asked.a.size()};
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (std::size_t s = 0; s < t; ++s)
            if (meet_beyond(mesh, mesh.triangles[s], mesh.triangles[t])) {
                truth.meet = LeagueTruth::Meet::yes;
                return truth;
            }
    return truth;
}

/// Vertices on a grid of integers. False if a triangle has no area there, or two vertices coincide.
bool put_on_grid(Mesh& mesh)
{
    for (Vector3d& v : mesh.vertices) v = v.array().round();
    mesh = make_mesh("mesh", std::move(mesh.vertices), std::move(mesh.triangles));
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
        for (std::size_t w = 0; w < v; ++w)
            if (mesh.vertices[v] == mesh.vertices[w]) return false;
    return std::ranges::all_of(mesh.triangles, [&](const Triangle& t) {
        const GridPoint a = grid_of(mesh.vertices[t[0]]);
        return cross(grid_of(mesh.vertices[t[1]]) - a, grid_of(mesh.vertices[t[2]]) - a) != GridPoint{0, 0, 0};
    });
}

LeagueFamily self_family(std::string name, std::string what, std::function<Mesh(CaseNumbers&)> make)
{
    return {"self: " + std::move(name),
            "a mesh against itself",
            LEAGUE_SELF,
            std::move(what),
            [make](std::uint64_t seed) {
                for (std::uint64_t k = 0;; ++k) {
                    CaseNumbers draw(seed + (k << 40));
                    Mesh mesh = make(draw);
                    if (put_on_grid(mesh)) return LeagueCase{.question = LEAGUE_SELF, .a = {std::move(mesh)}};
                }
            },
            meets_itself};
}

/// A ball or a ring of some tens of triangles, 200 m wide.
Mesh smooth(CaseNumbers& draw)
{
    Mesh mesh = draw.number(0, 1) ? make_sphere_mesh(1, 80) : make_torus_mesh(1, 0.4, 60);
    const Eigen::Matrix3d turn = 100 * draw.rotation();
    for (Vector3d& v : mesh.vertices) v = turn * v;
    return mesh;
}

} // namespace

std::vector<LeagueFamily> self_league()
{
    return {self_family("dented", "Balls and rings with vertices that are moved at random, a little or far.",
                        [](CaseNumbers& draw) {
                            Mesh mesh = smooth(draw);
                            const double reach = draw.magnitude(0, 7);
                            for (Vector3d& v : mesh.vertices)
                                if (draw.one_in(4)) v += reach * draw.vector();
                            return mesh;
                        }),
            self_family(
                "touching",
                "Balls and rings of which one vertex is on an edge or a face of another triangle, or next to it.",
                [](CaseNumbers& draw) {
                    Mesh mesh = smooth(draw);
                    for (Vector3d& v : mesh.vertices) v = 12 * (v / 12).array().round(); // halves and thirds are exact
                    const Triangle& t = mesh.triangles[draw.number(std::size_t{0}, mesh.triangles.size() - 1)];
                    const auto corner = [&](int k) { return mesh.vertices[t[std::size_t(k)]]; };
                    const Vector3d at = draw.number(0, 1) ? Vector3d((corner(0) + corner(1)) / 2)
                                                          : Vector3d((corner(0) + corner(1) + corner(2)) / 3);
                    std::uint32_t v = 0;
                    do v = draw.number(0u, std::uint32_t(mesh.vertices.size() - 1));
                    while (std::ranges::find(t, v) != t.end());
                    mesh.vertices[v] =
                        at + (draw.number(0, 1) ? Vector3d::Zero()
                                                : Vector3d(draw.number(-1, 1), draw.number(-1, 1), draw.number(-1, 1)));
                    return mesh;
                }),
            self_family("folded in a plane",
                        "Flat sheets of which vertices are moved within the plane: triangles overlap, or not.",
                        [](CaseNumbers& draw) {
                            Mesh mesh = make_sheet_mesh(80, 4);
                            for (Vector3d& v : mesh.vertices)
                                if (draw.one_in(5)) v += Vector3d(draw.real(-30, 30), draw.real(-30, 30), 0);
                            const Eigen::Matrix3d turn =
                                Eigen::Vector3d(draw.number(0, 2), draw.number(0, 2), 1) * Eigen::RowVector3d::UnitX();
                            for (Vector3d& v : mesh.vertices)
                                v = v.array().round(), v.z() = turn(0, 0) * v.x() + turn(1, 0) * v.y();
                            return mesh;
                        })};
}

} // namespace oncollide::tools
