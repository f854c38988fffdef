#include "league/truths/solids.hpp"

namespace oncollide::tools::truths {

using Eigen::Vector3d;
using oracle::SolidTruth;

std::vector<SolidTruth> parts_of(const LeagueBody& body, const Vector3d& origin, bool faces)
{
    std::vector<SolidTruth> parts;
    const auto add = [&](std::vector<Vector3d> points, bool with_faces = false) {
        if (with_faces)
            parts.emplace_back(Shape(ConvexHull{std::move(points)}), body.pose, origin);
        else
            parts.emplace_back(points, body.pose, origin);
    };
    if (const auto* shape = std::get_if<Shape>(&body.geometry)) parts.emplace_back(*shape, body.pose, origin);
    if (const auto* map = std::get_if<OccupancyMap>(&body.geometry))
        map->each_box([&](const Aabb& box) {
            const auto corners = corners_of(box);
            add({corners.begin(), corners.end()});
        });
    const auto triangles = [&](const Mesh& mesh) {
        for (const auto& [i, j, k] : mesh.triangles) add({mesh.vertices[i], mesh.vertices[j], mesh.vertices[k]}, faces);
    };
    if (const auto* terrain = std::get_if<Terrain>(&body.geometry)) triangles(mesh_of(*terrain));
    if (const auto* mesh = std::get_if<Mesh>(&body.geometry)) {
        if (body.solid)
            add(mesh->vertices, faces);
        else
            triangles(*mesh);
    }
    return parts;
}

std::shared_ptr<const Solids> solids_of(const LeagueCase& asked, bool faces)
{
    const Vector3d origin = asked.b.pose.translation();
    return std::make_shared<const Solids>(
        Solids{origin, parts_of(asked.a, origin, faces), parts_of(asked.b, origin, faces)});
}

std::vector<ConvexSet> sets_of(const LeagueBody& body)
{
    return convex_sets(body.geometry, body.pose);
}

} // namespace oncollide::tools::truths
