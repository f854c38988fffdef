#include "view/page_model.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include <meshoptimizer.h>

#include "render/drawn_mesh.hpp"

namespace oncollide::tools {
namespace {

using oncollide::Mesh;

/// Every `step`-th height of a terrain.
Mesh thinned(const Terrain& terrain, std::uint32_t step)
{
    const auto places = [&](std::uint32_t count) {
        std::vector<std::uint32_t> all;
        for (std::uint32_t k = 0; k + 1 < count; k += step) all.push_back(k);
        all.push_back(count - 1);
        return all;
    };
    const std::vector<std::uint32_t> columns = places(terrain.columns()), rows = places(terrain.rows());
    const auto width = static_cast<std::uint32_t>(columns.size());
    std::vector<Eigen::Vector3d> points;
    std::vector<bool> there;
    for (const std::uint32_t row : rows)
        for (const std::uint32_t column : columns) {
            Eigen::Vector3d point = terrain.point(column, row);
            there.push_back(point.allFinite());
            if (!there.back()) point.z() = terrain.bounds().min.z();
            points.push_back(point);
        }
    std::vector<Triangle> triangles;
    for (std::uint32_t y = 0; y + 1 < rows.size(); ++y)
        for (std::uint32_t x = 0; x + 1 < width; ++x) {
            const std::uint32_t a = y * width + x, b = a + 1, c = a + width, d = c + 1;
            if (there[a] && there[b] && there[d]) triangles.push_back({a, b, d});
            if (there[a] && there[d] && there[c]) triangles.push_back({a, d, c});
        }
    if (triangles.empty()) // all heights that were kept are holes
        triangles = {{0, width - 1, std::uint32_t(points.size()) - 1}};
    return make_mesh("terrain", std::move(points), std::move(triangles));
}

/// The cells of a map, merged into cubes large enough that there are at most `most`.
Mesh coarsened(const OccupancyMap& map, std::uint64_t most, bool& exactly)
{
    for (std::int32_t side = 1;; side *= 2) {
        std::vector<std::array<std::int32_t, 4>> cubes; // side, then the lowest corner
        bool too_many = false;
        map.each_cell(map.bounds(), [&](const MapCell& cell) {
            const auto wide = std::max<std::int32_t>(std::int32_t(cell.side), side);
            const auto down = [&](std::int32_t x) { return std::int32_t(std::floor(double(x) / wide)) * wide; };
            const std::array<std::int32_t, 4> cube{wide, down(cell.x), down(cell.y), down(cell.z)};
            if (cubes.empty() || cubes.back() != cube) cubes.push_back(cube);
            if (cubes.size() > 8 * most + 4096) {
                std::sort(cubes.begin(), cubes.end());
                cubes.erase(std::unique(cubes.begin(), cubes.end()), cubes.end());
                too_many = cubes.size() > most;
            }
            return !too_many;
        });
        std::sort(cubes.begin(), cubes.end());
        cubes.erase(std::unique(cubes.begin(), cubes.end()), cubes.end());
        if ((too_many || cubes.size() > most) && side < 1 << 14) continue;
        exactly = side == 1;
        std::vector<Aabb> boxes;
        for (const auto& [wide, x, y, z] : cubes) {
            const Eigen::Array3d low = Eigen::Array3d(x, y, z) * map.resolution();
            boxes.push_back({low, low + wide * map.resolution()});
        }
        return mesh_of_boxes("map", boxes);
    }
}

PageModel::Mesh in_box(const Mesh& mesh, const Aabb& box)
{
    PageModel::Mesh out;
    out.vertices.reserve(mesh.vertices.size()), out.indices.reserve(3 * mesh.triangles.size());
    for (const Eigen::Vector3d& v : mesh.vertices) out.vertices.push_back(fraction_of(box, v));
    for (const Triangle& t : mesh.triangles) out.indices.insert(out.indices.end(), t.begin(), t.end());
    return out;
}

/// Drops vertices that no triangle uses.
void compact(PageModel::Mesh& mesh)
{
    std::vector<std::array<std::uint16_t, 4>> padded(mesh.vertices.size()), used(mesh.vertices.size());
    for (std::size_t k = 0; k < padded.size(); ++k)
        padded[k] = {mesh.vertices[k][0], mesh.vertices[k][1], mesh.vertices[k][2], 0};
    const std::size_t count = meshopt_optimizeVertexFetch(used.data(), mesh.indices.data(), mesh.indices.size(),
                                                          padded.data(), padded.size(), sizeof(padded[0]));
    mesh.vertices.resize(count);
    for (std::size_t k = 0; k < count; ++k) mesh.vertices[k] = {used[k][0], used[k][1], used[k][2]};
}

/// The result keeps all vertices.
/// @param size  the size of the box, metres: simplification errors are measured in metres
PageModel::Mesh with_fewer_triangles(const PageModel::Mesh& fine, const Eigen::Vector3d& size, std::uint64_t triangles)
{
    std::vector<std::array<float, 3>> points;
    points.reserve(fine.vertices.size());
    for (const auto& v : fine.vertices)
        points.push_back({float(v[0] * size.x()), float(v[1] * size.y()), float(v[2] * size.z())});
    PageModel::Mesh coarse{fine.vertices, std::vector<std::uint32_t>(fine.indices.size())};
    const auto run = [&](auto simplify) {
        coarse.indices.resize(simplify(coarse.indices.data(), fine.indices.data(), fine.indices.size(),
                                       points[0].data(), points.size(), sizeof(points[0]), std::size_t(3 * triangles)));
    };
    run([](auto... given) { return meshopt_simplify(given..., 0.5f, 0, nullptr); });
    if (coarse.triangles() > triangles + triangles / 2) { // the mesh's topology prevents further simplification
        coarse.indices.resize(fine.indices.size());
        run([](auto... given) { return meshopt_simplifySloppy(given..., 1e9f, nullptr); });
    }
    return coarse.triangles() == 0 ? fine : coarse;
}

PageModel::Mesh simplified(const PageModel::Mesh& fine, const Eigen::Vector3d& size, std::uint64_t triangles)
{
    PageModel::Mesh coarse = with_fewer_triangles(fine, size, triangles);
    if (coarse.triangles() < fine.triangles()) compact(coarse);
    return coarse;
}

/// @param exactly  set to whether the result is the whole geometry
Mesh shown_mesh(const Scene& scene, const Geometry& geometry, std::uint64_t most, bool& exactly)
{
    if (const auto* map = std::get_if<OccupancyMap>(&geometry.data))
        return coarsened(*map, std::max<std::uint64_t>(most / 12, 1), exactly);
    if (const auto* terrain = std::get_if<Terrain>(&geometry.data)) {
        const double cells = double(terrain->cells_x()) * terrain->cells_y();
        const auto step = std::uint32_t(std::max(1.0, std::ceil(std::sqrt(2 * cells / double(most)))));
        exactly = step == 1;
        return thinned(*terrain, step);
    }
    return drawn_mesh(std::get<Shape>(geometry.data), scene);
}

std::string_view kind_in_page(const GeometryData& data)
{
    constexpr std::string_view kinds[] = {"mesh", "shape", "map", "terrain"};
    return kinds[data.index()];
}

std::uint64_t triangles_of(const Geometry& geometry)
{
    if (const auto* mesh = std::get_if<Mesh>(&geometry.data)) return mesh->triangles.size();
    if (const auto* terrain = std::get_if<Terrain>(&geometry.data)) return 2 * terrain->cells();
    if (const auto* map = std::get_if<OccupancyMap>(&geometry.data)) return map->count();
    return 0;
}

} // namespace

PageBlock PageModel::Mesh::block() const
{
    PageBlock block;
    const std::vector<std::uint16_t> narrow(indices.begin(), indices.end());
    if (vertices.size() > 65536) block.add(indices);
    block.add(std::span(vertices.empty() ? nullptr : vertices[0].data(), 3 * vertices.size()));
    if (vertices.size() <= 65536) block.add(narrow);
    return block;
}

std::uint64_t page_triangles(const Geometry& geometry)
{
    if (std::holds_alternative<OccupancyMap>(geometry.data)) return 12 * triangles_of(geometry);
    return std::max<std::uint64_t>(triangles_of(geometry), 12);
}

PageModel make_page_model(const Scene& scene, GeometryId id, std::uint64_t most)
{
    const Geometry& geometry = scene.geometries[index(id)];
    PageModel model;
    model.kind = kind_in_page(geometry.data), model.triangles = triangles_of(geometry);
    bool exactly = true;
    if (const auto* mesh = std::get_if<Mesh>(&geometry.data)) {
        model.box = mesh->bounds;
        model.meshes.push_back(in_box(*mesh, model.box));
    } else {
        const Mesh shown = shown_mesh(scene, geometry, most, exactly);
        model.box = shown.bounds;
        model.meshes.push_back(in_box(shown, model.box));
    }
    const Eigen::Vector3d size = model.box.max - model.box.min;
    if (model.kind == "mesh" && model.triangles > most)
        model.meshes[0] = simplified(model.meshes[0], size, most), exactly = false;
    model.simplified = !exactly;
    if (model.kind == "map") return model; // a heap of boxes cannot be simplified
    for (const std::uint64_t coarse : {1200, 160, 24})
        if (model.meshes.back().triangles() > 2 * coarse)
            model.meshes.push_back(simplified(model.meshes.back(), size, coarse));
    return model;
}

std::array<std::uint16_t, 3> fraction_of(const Aabb& box, const Eigen::Vector3d& point)
{
    const Eigen::Array3d size = (box.max - box.min).array().max(1e-300);
    const Eigen::Array3d at = ((point - box.min).array() / size).max(0).min(1) * 65535;
    return {std::uint16_t(std::lround(at.x())), std::uint16_t(std::lround(at.y())), std::uint16_t(std::lround(at.z()))};
}

PageModel make_page_model(const Scene& scene, GeometryId id, std::uint64_t most, std::vector<std::uint32_t>& source)
{
    const auto& mesh = std::get<Mesh>(scene.geometries[index(id)].data);
    PageModel model{.kind = "mesh", .box = mesh.bounds, .triangles = mesh.triangles.size(), .meshes = {}};
    model.simplified = model.triangles > most;
    PageModel::Mesh shown = in_box(mesh, model.box);
    if (model.simplified) shown = with_fewer_triangles(shown, model.box.max - model.box.min, most);
    constexpr std::uint32_t unused = ~0u;
    std::vector<std::uint32_t> place(mesh.vertices.size(), unused); // of the vertices that are shown
    source.clear();
    for (std::uint32_t& v : shown.indices) {
        if (place[v] == unused) place[v] = static_cast<std::uint32_t>(source.size()), source.push_back(v);
        v = place[v];
    }
    std::vector<std::array<std::uint16_t, 3>> vertices;
    for (const std::uint32_t v : source) vertices.push_back(shown.vertices[v]);
    shown.vertices = std::move(vertices);
    model.meshes.push_back(std::move(shown));
    return model;
}

} // namespace oncollide::tools
