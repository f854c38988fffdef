#include "clash/parts/mended_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <unordered_map>

#include <fmt/format.h>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;

/// Returns the first vertex within the distance, by vertex; first ones stay.
std::vector<std::uint32_t> welds_of(const std::vector<Vector3d>& points, double distance)
{
    using Cell = std::array<std::int64_t, 3>;
    struct Hash {
        std::size_t operator()(const Cell& c) const
        {
            return std::size_t(c[0] * 73856093) ^ std::size_t(c[1] * 19349663) ^ std::size_t(c[2] * 83492791);
        }
    };
    std::unordered_map<Cell, std::vector<std::uint32_t>, Hash> firsts;
    std::vector<std::uint32_t> first(points.size());
    for (std::uint32_t v = 0; v < points.size(); ++v) {
        const Vector3d at = points[v] / (2 * distance);
        first[v] = v;
        Cell low, high;
        for (std::size_t k = 0; k < 3; ++k) {
            low[k] = std::int64_t(std::floor(at[int(k)] - 0.5));
            high[k] = std::int64_t(std::floor(at[int(k)] + 0.5));
        }
        for (Cell c = low; c[0] <= high[0]; ++c[0])
            for (c[1] = low[1]; c[1] <= high[1]; ++c[1])
                for (c[2] = low[2]; c[2] <= high[2]; ++c[2])
                    if (const auto found = firsts.find(c); found != firsts.end())
                        for (const std::uint32_t other : found->second)
                            if (other < first[v] && (points[other] - points[v]).norm() <= distance) first[v] = other;
        if (first[v] == v) {
            Cell cell;
            for (std::size_t k = 0; k < 3; ++k) cell[k] = std::int64_t(std::floor(at[int(k)]));
            firsts[cell].push_back(v);
        }
    }
    return first;
}

struct Side {
    std::uint32_t triangle;
    bool forward; ///< it runs from the lesser vertex to the greater one
};
using Edge = std::pair<std::uint32_t, std::uint32_t>;
using Edges = std::map<Edge, std::vector<Side>>;

Edges edges_of(const std::vector<Triangle>& triangles)
{
    Edges edges;
    for (std::uint32_t t = 0; t < triangles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t from = triangles[t][k], to = triangles[t][(k + 1) % 3];
            edges[std::minmax(from, to)].push_back({t, from < to});
        }
    return edges;
}

/// Divides triangles with an odd edge at the ends of other odd edges that lie on it. Returns how many; `limit` counts
/// down the comparisons.
std::size_t split_at_corners(const std::vector<Vector3d>& points, std::vector<Triangle>& triangles, double distance,
                             std::int64_t& limit)
{
    std::map<Edge, std::vector<std::uint32_t>> cuts; // vertices on an edge, from its first to its second
    std::vector<std::uint32_t> corners;
    const Edges edges = edges_of(triangles);
    for (const auto& [edge, sides] : edges)
        if (sides.size() % 2) cuts[edge], corners.push_back(edge.first), corners.push_back(edge.second);
    std::ranges::sort(corners,
                      [&](auto u, auto v) { return std::pair(points[u].x(), u) < std::pair(points[v].x(), v); });
    corners.erase(std::ranges::unique(corners).begin(), corners.end());
    for (auto& [edge, on] : cuts) {
        const Vector3d &p = points[edge.first], &q = points[edge.second];
        const double length = (q - p).norm();
        const auto first = std::ranges::lower_bound(corners, std::min(p.x(), q.x()) - distance, {},
                                                    [&](std::uint32_t v) { return points[v].x(); });
        std::vector<std::pair<double, std::uint32_t>> found;
        for (auto v = first; v != corners.end() && points[*v].x() <= std::max(p.x(), q.x()) + distance; ++v) {
            if (--limit < 0) return 0;
            if (*v == edge.first || *v == edge.second) continue;
            const double along = (points[*v] - p).dot(q - p) / length;
            if (along <= 0 || along >= length) continue;
            if ((points[*v] - p - along / length * (q - p)).norm() <= distance) found.emplace_back(along, *v);
        }
        std::ranges::sort(found);
        for (const auto& [along, v] : found) on.push_back(v);
    }
    std::size_t split = 0;
    for (std::size_t t = 0; t < triangles.size(); ++t) { // new triangles follow, and are looked at in their turn
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t from = triangles[t][k], to = triangles[t][(k + 1) % 3],
                                apex = triangles[t][(k + 2) % 3];
            const auto cut = cuts.find(std::minmax(from, to));
            if (cut == cuts.end() || cut->second.empty()) continue;
            std::vector<std::uint32_t> chain = cut->second;
            if (std::ranges::count(chain, apex)) continue; // a sliver
            if (from > to) std::ranges::reverse(chain);
            chain.push_back(to);
            triangles[t] = {from, chain[0], apex};
            for (std::size_t i = 0; i + 1 < chain.size(); ++i) triangles.push_back({chain[i], chain[i + 1], apex});
            ++split;
            k = ~std::size_t(0); // its other edges, again
        }
    }
    return split;
}

/// Sets of triangles of which each knows whether it faces as its set's first one.
class Facings {
public:
    explicit Facings(std::size_t count) : above_(count), turned_(count, 0)
    {
        std::iota(above_.begin(), above_.end(), 0u);
    }

    std::pair<std::uint32_t, bool> root(std::uint32_t t)
    {
        std::uint32_t top = t;
        bool turned = false;
        for (; above_[top] != top; top = above_[top]) turned ^= turned_[top] != 0;
        for (bool rest = turned; above_[t] != t;) { // shorten the way
            const std::uint32_t next = above_[t];
            const bool own = turned_[t];
            above_[t] = top, turned_[t] = rest;
            rest ^= own, t = next;
        }
        return {top, turned};
    }
    /// Makes both face alike, or apart. False if they are in one set and do not.
    bool join(std::uint32_t a, std::uint32_t b, bool alike)
    {
        const auto [root_a, turned_a] = root(a);
        const auto [root_b, turned_b] = root(b);
        const bool differs = turned_a ^ turned_b ^ !alike;
        if (root_a == root_b) return !differs;
        above_[std::max(root_a, root_b)] = std::min(root_a, root_b);
        turned_[std::max(root_a, root_b)] = differs;
        return true;
    }

private:
    std::vector<std::uint32_t> above_;
    std::vector<std::uint8_t> turned_;
};

/// Turns triangles so that each edge is passed as often in one direction as in the other; false if that fails.
bool turn_alike(const std::vector<Vector3d>& points, std::vector<Triangle>& triangles, std::size_t& turned)
{
    const Edges edges = edges_of(triangles);
    Facings facings(triangles.size());
    const auto pair = [&](const Side& a, const Side& b) {
        return facings.join(a.triangle, b.triangle, a.forward != b.forward);
    };
    for (const auto& [edge, sides] : edges)
        if (sides.size() == 2 && !pair(sides[0], sides[1])) return false;
    for (const auto& [edge, sides] : edges) { // surfaces that meet in an edge: pairs of which each is consistent
        if (sides.size() == 2) continue;
        std::vector<Side> left = sides;
        const auto match = [&](auto fits) {
            for (std::size_t i = 0; i < left.size(); ++i)
                for (std::size_t j = i + 1; j < left.size(); ++j)
                    if (fits(left[i], left[j])) {
                        left.erase(left.begin() + std::ptrdiff_t(j)), left.erase(left.begin() + std::ptrdiff_t(i));
                        --i;
                        break;
                    }
        };
        match([&](const Side& a, const Side& b) {
            const auto [root_a, turned_a] = facings.root(a.triangle);
            const auto [root_b, turned_b] = facings.root(b.triangle);
            return root_a == root_b && (a.forward ^ turned_a) != (b.forward ^ turned_b);
        });
        match([&](const Side& a, const Side& b) {
            return facings.root(a.triangle).first != facings.root(b.triangle).first && pair(a, b);
        });
        if (!left.empty()) return false;
    }
    // A set whose triangles all faced alike stays; of another one the outside becomes the front.
    std::vector<double> volume(triangles.size(), 0);
    std::vector<std::array<std::size_t, 2>> count(triangles.size());
    const Vector3d origin = points[triangles[0][0]];
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        const auto [top, differs] = facings.root(t);
        const auto& [a, b, c] = triangles[t];
        const double part = (points[a] - origin).dot((points[b] - origin).cross(points[c] - origin));
        volume[top] += differs ? -part : part, ++count[top][differs];
    }
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        const auto [top, differs] = facings.root(t);
        const bool mixed = count[top][0] && count[top][1];
        if (mixed ? differs == (volume[top] >= 0) : false) std::swap(triangles[t][1], triangles[t][2]), ++turned;
    }
    return true;
}

} // namespace

std::string Mending::done() const
{
    std::string text;
    const auto add = [&](std::size_t count, const char* one, const char* many) {
        if (count) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, count == 1 ? one : many);
    };
    add(welded, "vertex welded", "vertices welded");
    add(split, "triangle split", "triangles split");
    add(turned, "triangle turned", "triangles turned");
    return text;
}

std::string Mending::why_open() const
{
    if (closed) return "";
    if (!open_edges) return "it has one side";
    return fmt::format("{} open edge{}", open_edges, open_edges == 1 ? "" : "s");
}

MendedMesh mended(const Mesh& mesh, double distance)
{
    MendedMesh result{mesh, {}};
    Mending& mending = result.mending;
    mending.closed = is_closed(mesh);
    if (mending.closed) return result;
    Mending done;
    std::vector<Triangle> triangles;
    const std::vector<std::uint32_t> first = welds_of(mesh.vertices, distance);
    std::vector<std::uint8_t> used(mesh.vertices.size(), 0);
    for (const Triangle& t : mesh.triangles) {
        for (const std::uint32_t v : t) {
            const double moved = (mesh.vertices[v] - mesh.vertices[first[v]]).norm();
            if (!used[v] && moved > 0) ++done.welded; // equal positions are one vertex already
            used[v] = 1, done.moved = std::max(done.moved, moved);
        }
        const Triangle now{first[t[0]], first[t[1]], first[t[2]]};
        // A triangle without area is no part of the surface; its edges lie on edges of its neighbours.
        if (!collinear(mesh.vertices[now[0]], mesh.vertices[now[1]], mesh.vertices[now[2]])) triangles.push_back(now);
    }
    if (triangles.empty()) return result;
    std::int64_t limit = 100'000'000;
    done.split = split_at_corners(mesh.vertices, triangles, 2 * distance, limit);
    if (done.split) done.moved += 2 * distance;
    for (const auto& [edge, sides] : edges_of(triangles))
        if (sides.size() % 2)
            ++mending.open_edges,
                mending.open_length += (mesh.vertices[edge.first] - mesh.vertices[edge.second]).norm();
    if (mending.open_edges || !turn_alike(mesh.vertices, triangles, done.turned)) return result;
    Mesh closed = make_mesh("mended", mesh.vertices, std::move(triangles));
    done.closed = is_closed(closed);
    if (done.closed) result = {std::move(closed), done};
    return result;
}

} // namespace oncollide::tools
