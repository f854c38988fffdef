#include <oncollide/narrowphase/inside/parts.hpp>

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/model/mesh_topology.hpp>

namespace oncollide {

namespace {

std::vector<PartPoints> points_of(const Mesh& mesh)
{
    std::vector<PartPoints> points;
    const std::vector<std::uint32_t> parts = parts_of(mesh);
    for (std::size_t i = 0; i < parts.size(); ++i)
        for (const std::uint32_t v : mesh.triangles[i]) {
            const Eigen::Vector3d& vertex = mesh.vertices[v];
            if (parts[i] == points.size()) points.emplace_back().fill(vertex);
            for (std::size_t k = 0; k < 6; ++k) {
                Eigen::Vector3d& extreme = points[parts[i]][k];
                const auto axis = static_cast<Eigen::Index>(k / 2);
                if (k % 2 ? vertex[axis] > extreme[axis] : vertex[axis] < extreme[axis]) extreme = vertex;
            }
        }
    return points;
}

} // namespace

std::vector<PartPoints> part_points_of(const GeometryData& geometry)
{
    const auto point = [](const Eigen::Vector3d& p) {
        PartPoints points;
        points.fill(p);
        return points;
    };
    if (const auto* mesh = std::get_if<Mesh>(&geometry)) return points_of(*mesh);
    if (const auto* shape = std::get_if<Shape>(&geometry)) {
        const auto* hull = std::get_if<ConvexHull>(shape); // the middle of its box need not be in it
        return {point(hull ? hull->points.front() : bounds_of(*shape).centre())};
    }
    return {}; // far too many
}

void refuse_open_mesh(const std::string& name, const Mesh& mesh)
{
    constexpr std::size_t most = 5;
    const std::vector<MeshEdge> open = open_edges(mesh);
    if (open.empty()) throw Error(ErrorKind::bad_data, fmt::format("{}: no triangle has an area, so no inside", name));
    std::vector<std::string> first;
    for (std::size_t i = 0; i < std::min(open.size(), most); ++i)
        first.push_back(fmt::format("{}-{}", open[i].from, open[i].to));
    throw Error(ErrorKind::bad_data,
                fmt::format("{}: the mesh is not closed, so it has no inside: {} open edge{} (vertices {}{}); an edge "
                            "must be shared by two triangles that run along it in opposite directions; "
                            "open-as-surface takes such meshes as surfaces",
                            name, open.size(), open.size() == 1 ? "" : "s", fmt::join(first, ", "),
                            open.size() > most ? ", ..." : ""));
}

} // namespace oncollide
