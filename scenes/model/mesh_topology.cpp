#include <oncollide/scenes/model/mesh_topology.hpp>

#include <algorithm>
#include <bit>
#include <compare>
#include <limits>
#include <numeric>
#include <span>

#include <oncollide/base/error.hpp>
#include <oncollide/base/numbers/random.hpp>
#include <oncollide/scenes/model/exact_area.hpp>

namespace oncollide {

namespace {

/// The lowest index of a vertex at the same position, for each vertex.
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

bool has_area(const Mesh& mesh, const Triangle& t)
{
    return !has_zero_area(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]);
}

/// False if some edge of a triangle with area has no partner in the opposite direction: the mesh is not closed. True:
/// it may be closed. A fast test that reads each triangle once and sums hashes whose sign is the edge's direction.
bool edges_may_cancel(const Mesh& mesh)
{
    std::vector<std::uint64_t> hashes(mesh.vertices.size());
    std::ranges::transform(mesh.vertices, hashes.begin(), [](const Eigen::Vector3d& v) {
        std::uint64_t hash = 0;
        for (const double x : v) hash = splitmix(hash ^ std::bit_cast<std::uint64_t>(x + 0.0)); // -0 is 0
        return hash;
    });
    std::uint64_t sum = 0;
    for (const Triangle& t : mesh.triangles) {
        if (!has_area(mesh, t)) continue;
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint64_t from = hashes[t[i]], to = hashes[t[(i + 1) % 3]];
            const std::uint64_t edge = splitmix(std::min(from, to) * 3 ^ std::max(from, to));
            sum += from < to ? edge : 0 - edge;
        }
    }
    return sum == 0;
}

/// A side of a triangle, as an edge between two positions.
struct Side {
    std::uint32_t low, high; ///< welded
    bool forward;            ///< the triangle runs from low to high
    MeshEdge edge;
};

/// Calls visit(sides between the same two positions, in the order of their triangles) for the triangles that `counts`
/// accepts.
void each_edge(const Mesh& mesh, auto counts, auto visit)
{
    const std::vector<std::uint32_t> first = weld(mesh.vertices);
    std::vector<Side> sides;
    sides.reserve(3 * mesh.triangles.size());
    for (const Triangle& t : mesh.triangles) {
        if (!counts(t)) continue;
        for (std::size_t i = 0; i < 3; ++i) {
            const MeshEdge edge{t[i], t[(i + 1) % 3]};
            const std::uint32_t from = first[edge.from], to = first[edge.to];
            if (from != to) sides.push_back({std::min(from, to), std::max(from, to), from < to, edge});
        }
    }
    std::stable_sort(sides.begin(), sides.end(),
                     [](const Side& x, const Side& y) { return x.low != y.low ? x.low < y.low : x.high < y.high; });
    for (auto begin = sides.begin(); begin != sides.end();) {
        const auto end = std::find_if(begin, sides.end(),
                                      [&](const Side& s) { return s.low != begin->low || s.high != begin->high; });
        visit(std::span<const Side>(&*begin, static_cast<std::size_t>(end - begin)));
        begin = end;
    }
}

} // namespace

std::vector<MeshEdge> open_edges(const Mesh& mesh)
{
    std::vector<MeshEdge> open;
    each_edge(
        mesh, [&](const Triangle& t) { return has_area(mesh, t); },
        [&](std::span<const Side> sides) {
            if (2 * std::ranges::count_if(sides, &Side::forward) != std::ptrdiff_t(sides.size()))
                open.push_back(sides[0].edge);
        });
    return open;
}

bool edges_are_even(const Mesh& mesh)
{
    bool even = true;
    each_edge(
        mesh, [](const Triangle&) { return true; },
        [&](std::span<const Side> sides) { even = even && sides.size() % 2 == 0; });
    return even;
}

bool is_closed(const Mesh& mesh)
{
    const bool some_area =
        std::any_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const Triangle& t) { return has_area(mesh, t); });
    return some_area && edges_may_cancel(mesh) && open_edges(mesh).empty();
}

std::vector<std::uint32_t> parts_of(const Mesh& mesh)
{
    std::vector<std::uint32_t> root = weld(mesh.vertices);
    const auto find = [&](std::uint32_t v) {
        while (root[v] != v) v = root[v] = root[root[v]];
        return v;
    };
    for (const Triangle& t : mesh.triangles)
        for (std::size_t i : {1, 2}) root[find(t[i])] = find(t[0]);
    constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> number(mesh.vertices.size(), none), parts;
    std::uint32_t count = 0;
    for (const Triangle& t : mesh.triangles) {
        std::uint32_t& part = number[find(t[0])];
        if (part == none) part = count++;
        parts.push_back(part);
    }
    ONCOLLIDE_ASSERT(parts.size() == mesh.triangles.size());
    return parts;
}

std::vector<bool> used_vertices(const Mesh& mesh)
{
    std::vector<bool> used(mesh.vertices.size());
    for (const Triangle& t : mesh.triangles)
        for (const std::uint32_t v : t) used[v] = true;
    return used;
}

} // namespace oncollide
