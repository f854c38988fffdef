#include <oncollide/scenes/mesh.hpp>

#include <algorithm>
#include <compare>
#include <limits>
#include <numeric>

#include <fmt/format.h>

#include "exact_area.hpp"
#include <oncollide/scenes/error.hpp>

namespace oncollide {

namespace {

constexpr double largest_coordinate = 1e15;

[[noreturn]] void fail(const std::string& name, const std::string& what)
{
    throw Error(ErrorKind::bad_data, fmt::format("{}: {}", name, what));
}

void check_vertices(const std::string& name, const std::vector<Eigen::Vector3d>& vertices)
{
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        const Eigen::Vector3d& v = vertices[i];
        if (!v.allFinite()) fail(name, fmt::format("vertex {} is not finite: ({}, {}, {})", i, v.x(), v.y(), v.z()));
        if (v.cwiseAbs().maxCoeff() > largest_coordinate)
            fail(name, fmt::format("vertex {} is too far from the origin: ({}, {}, {}), at most {} m are allowed", i,
                                   v.x(), v.y(), v.z(), largest_coordinate));
    }
}

/// For each vertex the lowest index of a vertex at the same position.
std::vector<std::uint32_t> weld(const std::vector<Eigen::Vector3d>& vertices)
{
    std::vector<std::uint32_t> order(vertices.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        const Eigen::Vector3d &p = vertices[a], &q = vertices[b];
        for (int axis = 0; axis < 3; ++axis)
            if (p[axis] != q[axis]) return p[axis] < q[axis];
        return a < b;
    });
    std::vector<std::uint32_t> first(vertices.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        const bool same = i > 0 && vertices[order[i]] == vertices[order[i - 1]];
        first[order[i]] = same ? first[order[i - 1]] : order[i];
    }
    return first;
}

} // namespace

Mesh make_mesh(const std::string& name, std::vector<Eigen::Vector3d> vertices, std::vector<Triangle> triangles)
{
    constexpr std::size_t most = std::numeric_limits<std::uint32_t>::max();
    if (triangles.empty()) fail(name, "the mesh has no triangle");
    if (vertices.size() > most || triangles.size() > most)
        fail(name, fmt::format("the mesh has {} vertices and {} triangles; at most {} of each are allowed",
                               vertices.size(), triangles.size(), most));
    check_vertices(name, vertices);

    Mesh mesh{.vertices = std::move(vertices), .triangles = std::move(triangles), .bounds = {}, .zero_area = 0};
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const Triangle& t = mesh.triangles[i];
        for (const std::uint32_t v : t)
            if (v >= mesh.vertices.size())
                fail(name, fmt::format("triangle {} uses vertex {}, but the mesh has {} vertices", i, v,
                                       mesh.vertices.size()));
        for (const std::uint32_t v : t) mesh.bounds.add(mesh.vertices[v]);
        mesh.zero_area += has_zero_area(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]);
    }
    return mesh;
}

Mesh transformed(const std::string& name, Mesh mesh, double scale, const Eigen::Vector3d& origin)
{
    for (Eigen::Vector3d& v : mesh.vertices) v = scale * (v - origin);
    return make_mesh(name, std::move(mesh.vertices), std::move(mesh.triangles));
}

bool is_closed(const Mesh& mesh)
{
    struct Edge {
        std::uint32_t low, high;
        bool forward; ///< the triangle runs from low to high
        auto operator<=>(const Edge&) const = default;
    };
    const std::vector<std::uint32_t> first = weld(mesh.vertices);
    std::vector<Edge> edges;
    edges.reserve(3 * mesh.triangles.size());
    for (const Triangle& t : mesh.triangles) {
        if (has_zero_area(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]])) continue;
        for (int i = 0; i < 3; ++i) {
            const std::uint32_t from = first[t[i]], to = first[t[(i + 1) % 3]];
            edges.push_back({std::min(from, to), std::max(from, to), from < to});
        }
    }
    if (edges.empty() || edges.size() % 2 != 0) return false;
    std::sort(edges.begin(), edges.end());
    for (std::size_t i = 0; i < edges.size(); i += 2) {
        const Edge &a = edges[i], &b = edges[i + 1];
        if (a.low != b.low || a.high != b.high || a.forward == b.forward) return false;
        // A third triangle on the edge would sort next to these two.
        if (i + 2 < edges.size() && edges[i + 2].low == a.low && edges[i + 2].high == a.high) return false;
    }
    return true;
}

} // namespace oncollide
