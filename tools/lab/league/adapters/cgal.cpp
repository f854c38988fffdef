// CGAL's trees of triangles with exact predicates, its test of solids, and its streamed segment trees for boxes. They
// are under the GPL: they serve only this comparison.
#include <algorithm>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <vector>

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Box_intersection_d/Box_with_info_d.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/intersection.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/boost/graph/helpers.h>
#include <CGAL/box_intersection_d.h>

#include "common.hpp"

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Triangles = std::vector<Kernel::Triangle_3>;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;
using SurfaceMesh = CGAL::Surface_mesh<Point>;
using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, std::uint32_t>;

std::vector<Point> points_of(const league_body& body)
{
    std::vector<Point> points;
    for (std::size_t i = 0; i < body.vertex_count; ++i) {
        const double* v = body.vertices + 3 * i;
        const auto [x, y, z] = league::to_world(body, {v[0], v[1], v[2]});
        points.emplace_back(x, y, z);
    }
    return points;
}

/// The triangles in the world. Throws if one has no area: CGAL's predicates do not allow it.
Triangles triangles_of(const league_body& body)
{
    const std::vector<Point> points = points_of(body);
    Triangles triangles;
    for (std::size_t i = 0; i < body.triangle_count; ++i) {
        const std::uint32_t* t = body.triangles + 3 * i;
        triangles.emplace_back(points.at(t[0]), points.at(t[1]), points.at(t[2]));
        if (triangles.back().is_degenerate()) throw std::domain_error("a triangle without area");
    }
    return triangles;
}

/// Throws if an edge has more than two triangles, or two in one direction.
SurfaceMesh linked_mesh_of(const league_body& body)
{
    const Triangles triangles = triangles_of(body);
    SurfaceMesh mesh;
    std::vector<SurfaceMesh::Vertex_index> vertices;
    for (const Point& p : points_of(body)) vertices.push_back(mesh.add_vertex(p));
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        const std::uint32_t* t = body.triangles + 3 * i;
        if (mesh.add_face(vertices[t[0]], vertices[t[1]], vertices[t[2]]) == SurfaceMesh::null_face())
            throw std::domain_error("no manifold");
    }
    for (const SurfaceMesh::Vertex_index v : mesh.vertices())
        if (mesh.is_isolated(v)) mesh.remove_vertex(v);
    mesh.collect_garbage();
    return mesh;
}

/// Throws if the mesh is not closed, or if its parts contradict each other about the inside: CGAL requires a volume.
SurfaceMesh closed_mesh_of(const league_body& body)
{
    SurfaceMesh mesh = linked_mesh_of(body);
    if (!CGAL::is_closed(mesh)) throw std::domain_error("not closed");
    if (!CGAL::Polygon_mesh_processing::does_bound_a_volume(mesh)) throw std::domain_error("no volume");
    return mesh;
}

/// Searches a tree of the first mesh for each triangle of the second.
struct Surfaces final : league::Query {
    Triangles a, b;
    Tree tree;

    explicit Surfaces(const league_case& asked)
        : a(triangles_of(asked.a)), b(triangles_of(asked.b)), tree(a.cbegin(), a.cend())
    {
        tree.build();
    }

    int answer(const league_case&, league_answer& answer) override
    {
        for (const Kernel::Triangle_3& triangle : b)
            if (tree.do_intersect(triangle)) {
                answer.meet = 1;
                break;
            }
        return LEAGUE_ANSWERED;
    }
};

struct Solids final : league::Query {
    SurfaceMesh a, b;

    explicit Solids(const league_case& asked) : a(closed_mesh_of(asked.a)), b(closed_mesh_of(asked.b)) {}

    int answer(const league_case&, league_answer& answer) override
    {
        namespace processing = CGAL::Polygon_mesh_processing;
        answer.meet = processing::do_intersect(a, b, CGAL::parameters::do_overlap_test_of_bounded_sides(true),
                                               CGAL::parameters::do_overlap_test_of_bounded_sides(true));
        return LEAGUE_ANSWERED;
    }
};

struct Rays final : league::Query {
    Triangles a;
    Tree tree;

    explicit Rays(const league_case& asked) : a(triangles_of(asked.a)), tree(a.cbegin(), a.cend()) { tree.build(); }

    /// Whether the segment meets a triangle is exact; the place is rounded.
    int answer(const league_case& asked, league_answer& answer) override
    {
        const Point from(asked.from[0], asked.from[1], asked.from[2]);
        const Kernel::Vector_3 motion(asked.motion[0], asked.motion[1], asked.motion[2]);
        if (!tree.do_intersect(Kernel::Segment_3(from, from + motion))) return LEAGUE_ANSWERED;
        const auto hit = tree.first_intersection(Kernel::Ray_3(from, motion));
        if (!hit) return LEAGUE_FAILED;
        const auto time = [&](const Point& p) { return (p - from) * motion / motion.squared_length(); };
        answer.meet = 1;
        if (const Point* point = boost::get<Point>(&hit->first))
            answer.time = time(*point);
        else {
            const auto& segment = boost::get<Kernel::Segment_3>(hit->first);
            answer.time = std::min(time(segment.source()), time(segment.target()));
        }
        answer.time = std::min(std::max(answer.time, 0.0), 1.0);
        return LEAGUE_ANSWERED;
    }
};

struct Boxes final : league::Query {
    std::vector<Box> boxes; ///< CGAL reorders them.
    std::vector<std::uint32_t> pairs;

    explicit Boxes(const league_case& asked)
    {
        for (std::uint32_t i = 0; i < asked.body_count; ++i) {
            const league_body& body = asked.bodies[i];
            double low[3], high[3];
            for (int k = 0; k < 3; ++k)
                low[k] = body.position[k] - body.size[k], high[k] = body.position[k] + body.size[k];
            boxes.emplace_back(low, high, i);
        }
    }

    int answer(const league_case&, league_answer& answer) override
    {
        pairs.clear();
        CGAL::box_self_intersection_d(boxes.begin(), boxes.end(), [&](const Box& a, const Box& b) {
            pairs.push_back(a.info()), pairs.push_back(b.info());
        });
        answer.pair_count = pairs.size() / 2;
        answer.pairs = pairs.data();
        return LEAGUE_ANSWERED;
    }
};

/// A mesh against itself.
struct SelfMesh final : league::Query {
    SurfaceMesh mesh;

    explicit SelfMesh(const league_case& asked) : mesh(linked_mesh_of(asked.a)) {}

    int answer(const league_case&, league_answer& answer) override
    {
        answer.meet = CGAL::Polygon_mesh_processing::does_self_intersect(mesh);
        return LEAGUE_ANSWERED;
    }
};

int supports(int question, int kind_a, int kind_b)
{
    switch (question) {
    case LEAGUE_MEET:
        return league::has_triangles(kind_a) && league::has_triangles(kind_b);
    case LEAGUE_RAY:
    case LEAGUE_SELF:
        return league::has_triangles(kind_a);
    default:
        return question == LEAGUE_PAIRS;
    }
}

/// Two solids, or two surfaces; rays only against surfaces.
std::unique_ptr<league::Query> prepare(const league_case& asked)
{
    const bool solid_a = league::is_solid_mesh(asked.a);
    switch (asked.question) {
    case LEAGUE_MEET:
        if (solid_a != league::is_solid_mesh(asked.b)) return nullptr;
        return solid_a ? league::make<Solids>(asked) : league::make<Surfaces>(asked);
    case LEAGUE_RAY:
        return solid_a ? nullptr : league::make<Rays>(asked);
    case LEAGUE_SELF:
        return league::make<SelfMesh>(asked);
    default:
        return league::make<Boxes>(asked);
    }
}

constexpr league_library libraries[] = {league::library_of<prepare>({
    .name = "cgal",
    .settings = CGAL_VERSION_STR
    "; Exact_predicates_inexact_constructions_kernel; AABB_tree of a, do_intersect() for each triangle of b; solids: "
    "Polygon_mesh_processing::do_intersect() of bounded sides; rays: first_intersection(); box_self_intersection_d(); "
    "does_self_intersect(); no triangles without area",
    .source = "CGAL/AABB_tree.h, Polygon_mesh_processing/intersection.h, box_intersection_d.h",
    .supports = supports,
})};

} // namespace

const league_library* league_open(int number)
{
    return league::library_at(libraries, number);
}
