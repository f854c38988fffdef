#include <oncollide/narrowphase/shapes/convex_surface.hpp>

#include <algorithm>
#include <set>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/scenes/model/convex_hull.hpp>
#include <oncollide/scenes/model/hull_slack.hpp>

namespace oncollide {

namespace {

using Points = std::span<const Eigen::Vector3d>;

bool is_outside(Points points, const Triangle& face, std::uint32_t p)
{
    return orient3d(points[face[0]], points[face[1]], points[face[2]], points[p]) > 0;
}

/// True if the hull is closed, convex at every edge, and contains all points.
bool is_surface_of(const Hull& hull, Points points)
{
    const auto neighbours = neighbours_of(hull.triangles);
    if (!neighbours) return false;
    std::vector<std::uint8_t> corner(points.size());
    for (std::size_t f = 0; f < hull.triangles.size(); ++f) {
        const Triangle& face = hull.triangles[f];
        if (collinear(points[face[0]], points[face[1]], points[face[2]])) return false;
        for (std::uint32_t v : face) corner[v] = 1;
        for (std::uint32_t other : (*neighbours)[f])
            for (std::uint32_t v : hull.triangles[other])
                if (is_outside(points, face, v)) return false;
    }
    for (std::uint32_t p = 0; p < points.size(); ++p)
        if (!corner[p] &&
            std::ranges::any_of(hull.triangles, [&](const Triangle& f) { return is_outside(points, f, p); }))
            return false;
    return true;
}

/// A tetrahedron with volume; empty if there is none.
std::vector<Triangle> first_faces(Points points)
{
    const auto count = static_cast<std::uint32_t>(points.size());
    const std::uint32_t a = 0;
    std::uint32_t b = 1, c = 1, d = 1;
    while (b < count && points[b] == points[a]) ++b;
    if (b == count) return {};
    while (c < count && collinear(points[a], points[b], points[c])) ++c;
    if (c == count) return {};
    while (d < count && orient3d(points[a], points[b], points[c], points[d]) == 0) ++d;
    if (d == count) return {};
    if (is_outside(points, {a, b, c}, d)) std::swap(b, c);
    return {{a, b, c}, {a, d, b}, {b, d, c}, {c, d, a}};
}

/// Adds a point: the faces that a point outside sees are replaced by a fan from the point to their rim. A face whose
/// plane contains the point is not seen, so every new triangle has an area.
void add_point(std::vector<Triangle>& faces, Points points, std::uint32_t p)
{
    const auto seen =
        std::partition(faces.begin(), faces.end(), [&](const Triangle& f) { return !is_outside(points, f, p); });
    if (seen == faces.end()) return;
    std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
    for (auto face = seen; face != faces.end(); ++face)
        for (std::size_t k = 0; k < 3; ++k) edges.emplace((*face)[k], (*face)[(k + 1) % 3]);
    faces.erase(seen, faces.end());
    for (const auto& [from, to] : edges)
        if (!edges.contains({to, from})) faces.push_back({from, to, p});
}

} // namespace

std::vector<Triangle> convex_surface(Points points)
{
    const Hull hull = convex_hull(points);
    if (!hull.triangles.empty() && is_surface_of(hull, points)) return hull.triangles;
    std::vector<Triangle> faces = first_faces(points);
    if (faces.empty()) return faces;
    for (std::uint32_t p : hull.vertices) add_point(faces, points, p);
    for (std::uint32_t p = 0; p < points.size(); ++p) add_point(faces, points, p);
    return faces;
}

} // namespace oncollide
