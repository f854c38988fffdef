#include <oncollide/narrowphase/inside/parts.hpp>

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/cooked/cooked_terrain.hpp>
#include <oncollide/scenes/model/mesh_topology.hpp>

namespace oncollide {

namespace {

void add(PartPoints& points, const Eigen::Vector3d& vertex)
{
    for (std::size_t k = 0; k < 6; ++k) {
        const auto axis = static_cast<Eigen::Index>(k / 2);
        if (k % 2 ? vertex[axis] > points[k][axis] : vertex[axis] < points[k][axis]) points[k] = vertex;
    }
}

std::vector<PartPoints> points_of(const Mesh& mesh)
{
    std::vector<PartPoints> points;
    const std::vector<std::uint32_t> parts = parts_of(mesh);
    for (std::size_t i = 0; i < parts.size(); ++i)
        for (const std::uint32_t v : mesh.triangles[i]) {
            const Eigen::Vector3d& vertex = mesh.vertices[v];
            if (parts[i] == points.size()) points.emplace_back().fill(vertex);
            add(points[parts[i]], vertex);
        }
    return points;
}

/// A connected part of a terrain, by the columns and rows of its outermost points.
struct TerrainPart {
    Terrain::Place left, right, front, back;

    void add(Terrain::Place place)
    {
        if (place.column < left.column) left = place;
        if (place.column > right.column) right = place;
        if (place.row < front.row) front = place;
        if (place.row > back.row) back = place;
    }
};

/// Cells that share a corner are in one part.
std::vector<PartPoints> points_of(const Terrain& terrain)
{
    const std::uint32_t nx = terrain.cells_x(), ny = terrain.cells_y();
    if (!terrain.holes()) {
        const Eigen::Vector3d least = terrain.point(0, 0), right = terrain.point(nx, 0), back = terrain.point(0, ny);
        return {{least, right, back, terrain.point(nx, ny), right, back}};
    }
    constexpr std::uint32_t none = 0xffffffff;
    std::vector<TerrainPart> parts;
    std::vector<std::uint32_t> joined; // by part: a joined part with a lower number, or itself
    const auto part_of = [&](std::uint32_t part) {
        while (joined[part] != part) part = joined[part] = joined[joined[part]];
        return part;
    };
    std::vector<std::uint32_t> below(nx + 2, none), here(nx + 2, none); // parts of two rows of cells
    std::vector<bool> there;
    for (std::uint32_t y = 0; y < ny; ++y, below.swap(here)) {
        terrain.read_cells(y, there);
        for (std::uint32_t x = 0; x < nx; ++x) {
            std::uint32_t& part = here[x + 1] = none;
            if (!there[x]) continue;
            for (const std::uint32_t other : {here[x], below[x], below[x + 1], below[x + 2]}) {
                if (other == none || other == part) continue;
                const std::uint32_t p = part_of(other), q = part == none ? p : part_of(part);
                joined[std::max(p, q)] = part = std::min(p, q);
            }
            if (part == none) {
                joined.push_back(part = static_cast<std::uint32_t>(joined.size()));
                parts.push_back({{x, y}, {x, y}, {x, y}, {x, y}});
            }
            parts[part].add({x, y}), parts[part].add({x + 1, y + 1});
        }
    }
    std::vector<PartPoints> points;
    for (auto i = static_cast<std::uint32_t>(parts.size()); i-- > 0;) {
        const TerrainPart& part = parts[i];
        const std::array<Terrain::Place, 6> places{part.left, part.right, part.front, part.back, part.left, part.right};
        if (joined[i] != i) { // joined to a later part
            for (const Terrain::Place& place : places) parts[joined[i]].add(place);
            continue;
        }
        PartPoints& of = points.emplace_back();
        for (std::size_t k = 0; k < 6; ++k) of[k] = terrain.point(places[k].column, places[k].row);
    }
    return points;
}

} // namespace

std::vector<PartPoints> part_points_of(const Mesh& mesh)
{
    return points_of(mesh);
}

std::vector<PartPoints> part_points_of(const Terrain& terrain)
{
    if (const CookedTerrainChunks* chunks = cooked_chunks(terrain))
        if (const auto& known = chunks->cooked()->parts()) return *known;
    return points_of(terrain);
}

std::vector<PartPoints> part_points_of(const GeometryData& geometry)
{
    const auto point = [](const Eigen::Vector3d& p) {
        PartPoints points;
        points.fill(p);
        return points;
    };
    if (const auto* mesh = std::get_if<Mesh>(&geometry)) return points_of(*mesh);
    if (const auto* shape = std::get_if<Shape>(&geometry)) {
        const auto* hull = std::get_if<ConvexHull>(shape); // other shapes contain their origin
        return {point(hull ? hull->points.front() : Eigen::Vector3d::Zero())};
    }
    if (const auto* terrain = std::get_if<Terrain>(&geometry)) return part_points_of(*terrain);
    return {}; // a map has far too many
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
