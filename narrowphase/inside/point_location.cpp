#include <oncollide/narrowphase/inside/point_location.hpp>

#include <optional>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/exact/exact_predicates.hpp>

namespace oncollide {

namespace {

/// The triangles of the mesh that represents a ray. There are three because each then gets a box of its own.
enum : std::uint32_t { segment, start, end };

Mesh ray_from(const Eigen::Vector3d& point, const Eigen::Vector3d& tip)
{
    Mesh ray{.vertices = {point, tip}, .triangles = {{0, 1, 1}, {0, 0, 0}, {1, 1, 1}}, .bounds = {}, .zero_area = 3};
    ray.bounds.add(point), ray.bounds.add(tip);
    return ray;
}

TrianglePoints corners(const Mesh& mesh, std::uint32_t triangle, const RelativePose& into)
{
    const Triangle& t = mesh.triangles[triangle];
    return {into(mesh.vertices[t[0]]), into(mesh.vertices[t[1]]), into(mesh.vertices[t[2]])};
}

/// True for a triangle without area as stored: it is not a part of the closed surface.
bool flat(const Mesh& mesh, std::uint32_t triangle)
{
    const Triangle& t = mesh.triangles[triangle];
    return mesh.zero_area > 0 && collinear(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]);
}

void meet_all(const Mesh& ray, const Mesh& mesh, const RelativePose& into, std::vector<TrianglePair>& hits)
{
    const TrianglePoints line{ray.vertices[0], ray.vertices[1], ray.vertices[1]};
    const TrianglePoints point{ray.vertices[0], ray.vertices[0], ray.vertices[0]};
    hits.clear();
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const TrianglePoints triangle = corners(mesh, t, into);
        if (!triangles_meet(line, triangle)) continue;
        hits.push_back({segment, t});
        if (triangles_meet(point, triangle)) hits.push_back({start, t});
    }
}

/// The location according to the triangles that the ray meets; none if the ray only touches one of them.
std::optional<PointLocation> judge(const Mesh& ray, const Mesh& mesh, const RelativePose& into,
                                   const std::vector<TrianglePair>& hits)
{
    const Eigen::Vector3d &point = ray.vertices[0], &tip = ray.vertices[1];
    int winding = 0;
    bool touches = false;
    for (const auto& [what, t] : hits) {
        if (what == start) return PointLocation::surface;
        if (what != segment || flat(mesh, t)) continue;
        const TrianglePoints triangle = corners(mesh, t, into);
        touches |= triangle_contact({point, tip, tip}, triangle) != TriangleContact::crossing;
        winding += orient3d(triangle[0], triangle[1], triangle[2], point);
    }
    if (touches) return std::nullopt;
    return winding ? PointLocation::inside : PointLocation::outside;
}

} // namespace

PointLocation PointLocator::place(const Eigen::Vector3d& point, const Mesh& mesh, ObbTree* tree,
                                  const RelativePose& into)
{
    const Eigen::Vector3d centre = into(mesh.bounds.centre()), from_centre = point - centre;
    // All of the moved mesh is within this distance of its centre: poses may be 2^-20 from rigid, and coordinates
    // round.
    const double largest =
        std::max({mesh.bounds.centre().stableNorm(), into.translation.stableNorm(), point.stableNorm()});
    const double radius =
        0.5 * (mesh.bounds.max - mesh.bounds.min).stableNorm() * (1 + 0x1p-16) + 0x1p-46 * largest + 1e-30;
    if (from_centre.stableNorm() > radius) return PointLocation::outside;
    // The ray leaves the mesh by a short way, but not along an axis, because edges of many meshes are along the axes.
    // Directions that touch an edge have measure zero, so this ends.
    for (std::uint64_t attempt = 0;; ++attempt) {
        Eigen::Vector3d way = from_centre / radius;
        for (std::uint64_t k = 0; k < 3; ++k) way[int(k)] += 0.25 * double(attempt + 1) * (u01(1, attempt, k) - 0.5);
        way.normalize();
        const Mesh ray = ray_from(point, point + (1.0625 * radius - from_centre.dot(way)) * way);
        if (tree) {
            ObbTree ray_tree(ray);
            walk_.all_meeting(ray_tree, *tree, into, hits_);
        } else
            meet_all(ray, mesh, into, hits_);
        if (const auto place = judge(ray, mesh, into, hits_)) return *place;
    }
}

} // namespace oncollide
