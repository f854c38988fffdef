#include <oncollide/scenes/geometry.hpp>

#include <oncollide/scenes/cooked/cooked_mesh.hpp>

namespace oncollide {

namespace {

Aabb bounds_of(const Mesh& mesh)
{
    return mesh.bounds;
}

Aabb bounds_of(const OccupancyMap& map)
{
    return map.bounds();
}

Aabb bounds_of(const Terrain& terrain)
{
    return terrain.bounds();
}

Aabb bounds_of(const std::shared_ptr<const CookedMesh>& mesh)
{
    return mesh->bounds();
}

} // namespace

Aabb bounds_of(const GeometryData& geometry)
{
    return std::visit([](const auto& data) { return bounds_of(data); }, geometry);
}

Aabb bounds_of(const Geometry& geometry)
{
    return bounds_of(geometry.data);
}

void check_geometry(const std::string& name, const GeometryData& geometry)
{
    if (const auto* mesh = std::get_if<Mesh>(&geometry)) check_mesh(name, *mesh);
    if (const auto* shape = std::get_if<Shape>(&geometry)) check_shape(name, *shape);
    if (const auto* cooked = std::get_if<std::shared_ptr<const CookedMesh>>(&geometry); cooked && !*cooked)
        refuse(name, "there is no cooked mesh");
}

} // namespace oncollide
