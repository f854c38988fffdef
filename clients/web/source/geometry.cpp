// Geometries: made from arrays, read from files (in Emscripten's file system in memory), generated.
#include "geometry.hpp"
#include "call.hpp"

#include <cstring>

#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

using namespace oncollide;
using namespace oncollide::web;

namespace {

HeldGeometry* hold(GeometryData data, const char* name)
{
    check_geometry(name, data);
    return new HeldGeometry{std::make_shared<const Geometry>(Geometry{name, std::move(data), {}})};
}

template <class Number>
std::vector<Eigen::Vector3d> points_at(const Number* numbers, std::size_t count)
{
    std::vector<Eigen::Vector3d> points(count);
    for (std::size_t i = 0; i < count; ++i)
        points[i] = {double(numbers[3 * i]), double(numbers[3 * i + 1]), double(numbers[3 * i + 2])};
    return points;
}

const Mesh& mesh_in(const HeldGeometry& held)
{
    const Mesh* const mesh = std::get_if<Mesh>(&held.geometry->data);
    if (!mesh) throw Error(ErrorKind::usage, "the geometry '" + held.geometry->name + "' is not a mesh; only meshes have vertices and faces");
    return *mesh;
}

/// A number for each kind; lib/geometry.mjs has their names.
int kind_of(const GeometryData& data)
{
    if (const Shape* const shape = std::get_if<Shape>(&data)) return 3 + static_cast<int>(shape->index());
    return std::holds_alternative<Mesh>(data) ? 0 : std::holds_alternative<OccupancyMap>(data) ? 1 : 2;
}

} // namespace

/// @param single  the vertices are floats
/// @param faces   null: each three vertices make a face
ONCOLLIDE_WEB int oc_mesh(const void* vertices, std::size_t count, bool single, const std::uint32_t* faces,
                          std::size_t face_count, const char* name, HeldGeometry** made)
{
    return call([=] {
        std::vector<Eigen::Vector3d> points = single ? points_at(static_cast<const float*>(vertices), count)
                                                     : points_at(static_cast<const double*>(vertices), count);
        std::vector<Triangle> triangles(face_count);
        if (faces) std::memcpy(triangles.data(), faces, face_count * sizeof(Triangle));
        for (std::uint32_t i = 0; !faces && i < face_count; ++i) triangles[i] = {3 * i, 3 * i + 1, 3 * i + 2};
        *made = hold(make_mesh(name, std::move(points), std::move(triangles)), name);
    });
}

/// @param kind  a place in Shape; hulls have oc_hull()
ONCOLLIDE_WEB int oc_shape(int kind, double x, double y, double z, const char* name, HeldGeometry** made)
{
    return call([=] {
        const auto shape = [&]() -> Shape {
            switch (kind) {
            case 0:
                return Sphere{x};
            case 1:
                return Box{{x, y, z}};
            case 2:
                return Capsule{x, y};
            case 3:
                return Cylinder{x, y};
            case 5:
                return Ellipsoid{{x, y, z}};
            case 6:
                return Cone{x, y};
            default:
                return HalfSpace{};
            }
        };
        *made = hold(shape(), name);
    });
}

ONCOLLIDE_WEB int oc_hull(const double* points, std::size_t count, const char* name, HeldGeometry** made)
{
    return call([=] { *made = hold(ConvexHull{points_at(points, count)}, name); });
}

/// @param heights  row by row
ONCOLLIDE_WEB int oc_terrain(const double* heights, std::uint32_t columns, std::uint32_t rows, double spacing_x,
                             double spacing_y, const double* origin, double error, const char* name,
                             HeldGeometry** made)
{
    return call([=] {
        const TerrainGrid grid{.columns = columns,
                               .rows = rows,
                               .spacing = {spacing_x, spacing_y},
                               .origin = Eigen::Map<const Eigen::Vector3d>(origin),
                               .no_data = std::nan(""),
                               .error = error};
        *made = hold(make_terrain(name, grid, std::span(heights, std::size_t{columns} * rows)), name);
    });
}

/// @param cells  three coordinates each, in cells
ONCOLLIDE_WEB int oc_map(const std::int32_t* cells, std::size_t count, double resolution, const char* name,
                         HeldGeometry** made)
{
    return call([=] {
        std::vector<MapCell> cubes(count);
        for (std::size_t i = 0; i < count; ++i) cubes[i] = {cells[3 * i], cells[3 * i + 1], cells[3 * i + 2], 1};
        *made = hold(make_occupancy_map(name, resolution, cubes), name);
    });
}

/// Reads a file of Emscripten's file system.
ONCOLLIDE_WEB int oc_load(const char* path, double scale, double fit, bool centre, const char* name,
                          HeldGeometry** made)
{
    return call([=] {
        GeometryData data = kind_of_file(path) == FileKind::mesh
                                ? GeometryData(load_mesh(path, {.scale = scale, .fit_diagonal = fit, .centre = centre}))
                                : load_geometry(path)->data;
        *made = hold(std::move(data), name);
    });
}

/// The generators of meshes, by number; see samples/generators.hpp.
ONCOLLIDE_WEB int oc_sample(int kind, double a, double b, double c, double d, double e, double triangles,
                            const char* name, HeldGeometry** made)
{
    return call([=] {
        const int count = static_cast<int>(triangles);
        const auto mesh = [&]() -> Mesh {
            switch (kind) {
            case 0:
                return make_box_mesh({a, b, c});
            case 1:
                return make_sphere_mesh(a, count);
            case 2:
                return make_torus_mesh(a, b, count);
            default:
                return make_torus_knot_mesh(static_cast<int>(a), static_cast<int>(b), c, d, e, count);
            }
        };
        *made = hold(mesh(), name);
    });
}

ONCOLLIDE_WEB void oc_geometry_free(HeldGeometry* held)
{
    delete held;
}

/// Kind, vertices, triangles, and the two corners of the bounds.
ONCOLLIDE_WEB int oc_geometry_info(const HeldGeometry* held)
{
    return call([=] {
        const Mesh* const mesh = std::get_if<Mesh>(&held->geometry->data);
        const Aabb bounds = bounds_of(*held->geometry);
        ColumnWriter row(results(), 1, 9);
        row.next(0, kind_of(held->geometry->data));
        row.next(0, mesh ? double(mesh->vertices.size()) : 0);
        row.next(0, mesh ? double(mesh->triangles.size()) : 0);
        row.next(0, bounds.min), row.next(0, bounds.max);
    });
}
ONCOLLIDE_WEB int oc_geometry_closed(const HeldGeometry* held, int* closed)
{
    return call([=] { *closed = is_closed(mesh_in(*held)); });
}
/// Where the vertices of a mesh lie: three doubles each.
ONCOLLIDE_WEB int oc_geometry_vertices(const HeldGeometry* held, const double** at)
{
    static_assert(sizeof(Eigen::Vector3d) == 3 * sizeof(double));
    return call([=] { *at = mesh_in(*held).vertices.data()->data(); });
}
ONCOLLIDE_WEB int oc_geometry_faces(const HeldGeometry* held, const std::uint32_t** at)
{
    return call([=] { *at = mesh_in(*held).triangles.data()->data(); });
}
