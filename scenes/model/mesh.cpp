#include <oncollide/scenes/model/mesh.hpp>

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/model/exact_area.hpp>
#include <oncollide/scenes/model/vertex_mover.hpp>

namespace oncollide {

void check_vertices(const std::string& name, std::span<const Eigen::Vector3d> vertices, std::size_t first)
{
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        const Eigen::Vector3d& v = vertices[i];
        if (!v.allFinite())
            refuse(name, fmt::format("vertex {} is not finite: ({}, {}, {})", first + i, v.x(), v.y(), v.z()));
        if (v.cwiseAbs().maxCoeff() > largest_coordinate)
            refuse(name, fmt::format("vertex {} is too far from the origin: ({}, {}, {}), at most {} m are allowed",
                                     first + i, v.x(), v.y(), v.z(), largest_coordinate));
    }
}

Mesh make_mesh(const std::string& name, std::vector<Eigen::Vector3d> vertices, std::vector<Triangle> triangles)
{
    constexpr std::size_t most = std::numeric_limits<std::uint32_t>::max();
    if (triangles.empty()) refuse(name, "the mesh has no triangle");
    if (vertices.size() > most || triangles.size() > most)
        refuse(name, fmt::format("the mesh has {} vertices and {} triangles; at most {} of each are allowed",
                                 vertices.size(), triangles.size(), most));
    check_vertices(name, vertices);

    Mesh mesh{.vertices = std::move(vertices), .triangles = std::move(triangles), .bounds = {}, .zero_area = 0};
    std::vector<char> used(mesh.vertices.size());
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const Triangle& t = mesh.triangles[i];
        for (const std::uint32_t v : t)
            if (v >= mesh.vertices.size())
                refuse(name, fmt::format("triangle {} uses vertex {}, but the mesh has {} vertices", i, v,
                                         mesh.vertices.size()));
        for (const std::uint32_t v : t) used[v] = 1;
        mesh.zero_area += has_zero_area(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]);
    }
    Aabb bounds; // a local, which the compiler can keep in registers
    for (std::size_t i = 0; i < used.size(); ++i)
        if (used[i]) bounds.add(mesh.vertices[i]);
    mesh.bounds = bounds;
    ONCOLLIDE_ASSERT(!bounds.empty() && mesh.zero_area <= mesh.triangles.size());
    return mesh;
}

void check_mesh(const std::string& name, const Mesh& mesh)
{
    if (mesh.triangles.empty()) refuse(name, "the mesh has no triangle");
    check_vertices(name, mesh.vertices);
    Aabb bounds;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        for (const std::uint32_t v : mesh.triangles[i]) {
            if (v >= mesh.vertices.size())
                refuse(name, fmt::format("triangle {} uses vertex {}, but the mesh has {} vertices", i, v,
                                         mesh.vertices.size()));
            bounds.add(mesh.vertices[v]);
        }
    if (bounds.min != mesh.bounds.min || bounds.max != mesh.bounds.max)
        refuse(name, "the mesh's bounds differ from its triangles' bounds; make it with make_mesh");
}

Mesh transformed(const std::string& name, Mesh mesh, double scale, const Eigen::Vector3d& origin)
{
    for (Eigen::Vector3d& v : mesh.vertices) v = scale * (v - origin);
    return make_mesh(name, std::move(mesh.vertices), std::move(mesh.triangles));
}

} // namespace oncollide
