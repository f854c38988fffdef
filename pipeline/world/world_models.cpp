// World: its models.
#include <oncollide/pipeline/world/world_impl.hpp>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>

namespace oncollide {

namespace {

/// The name of a geometry in errors.
const std::string& title_of(const std::string& name, const GeometryData& data)
{
    static const std::string kinds[] = {"mesh", "shape", "map", "terrain", "mesh"}; // names of the alternatives
    return name.empty() ? kinds[data.index()] : name;
}
const std::string& title_of(const Geometry& geometry)
{
    return title_of(geometry.name, geometry.data);
}

std::shared_ptr<const Geometry> checked(std::string name, GeometryData data)
{
    check_geometry(title_of(name, data), data);
    return std::make_shared<const Geometry>(Geometry{std::move(name), std::move(data), {}});
}
std::shared_ptr<const Geometry> checked(std::shared_ptr<const Geometry> geometry)
{
    if (!geometry) throw Error(ErrorKind::usage, "model: no geometry given");
    check_geometry(geometry->name.empty() ? "model" : geometry->name, geometry->data);
    return geometry;
}

} // namespace

template <class Visit>
void WorldImpl::each_body(ModelId id, Visit visit)
{
    std::uint32_t left = id.slot < users.size() ? users[id.slot] : 0;
    for (std::uint32_t slot = 0; left > 0; ++slot)
        if (bodies.alive(slot) && bodies.model_id(slot) == id) visit(slot), --left;
}

void WorldImpl::replace(ModelId id, std::shared_ptr<const Geometry> geometry)
{
    model_of(id);
    if (settings.mode == Mode::solid && id.slot < users.size() && users[id.slot]) check_inside(Model(geometry));
    models.replace(id, std::move(geometry));
    each_body(id, [&](std::uint32_t slot) { bodies.set_model(slot, &models[id], id); });
    changed();
}

const Mesh& WorldImpl::check_vertices(ModelId id)
{
    const Model& model = model_of(id);
    const auto refuse = [&](const char* why) {
        throw Error(ErrorKind::usage, text_of("model", id.slot, id.generation) + why);
    };
    if (model.cooked())
        refuse(": is a mesh in a cooked file, whose vertices are fixed; add CookedMesh::whole() instead");
    if (!model.is_mesh()) refuse(": is not a mesh, so it has no vertices to set; replace() gives it another geometry");
    return std::get<Mesh>(model.geometry().data);
}

void WorldImpl::set_vertices(ModelId id, std::size_t first, std::span<const Eigen::Vector3d> positions)
{
    const bool solid = settings.mode == Mode::solid;
    if (solid && id.slot < users.size() && users[id.slot]) {
        const auto moved = std::make_shared<Geometry>(models[id].geometry());
        auto& mesh = std::get<Mesh>(moved->data);
        VertexMover(mesh).move(title_of(*moved), mesh, first, positions);
        check_inside(Model(moved));
    }
    if (!models.owns_vertices(id)) {
        oncollide::check_vertices(title_of(models[id].geometry()), positions, first); // before anything changes
        replace(id, models.own(id));
        models.own_vertices(id);
    }
    const double moved = models.move_vertices(id, title_of(models[id].geometry()), first, positions);
    if (moved == 0) return;
    each_body(id, [&](std::uint32_t slot) {
        // The memory of solid bodies does not hold for as long as their surfaces are apart: an open mesh may now be
        // closed.
        solid ? bodies.set_model(slot, &models[id], id) : bodies.deform(slot, moved);
    });
    changed();
}

void WorldImpl::check_heights(ModelId id, const TerrainRectangle& where, std::size_t count)
{
    const Model& model = model_of(id);
    const auto refuse = [&](const std::string& why) {
        throw Error(ErrorKind::usage, text_of("model", id.slot, id.generation) + ": " + why);
    };
    if (!model.terrain()) refuse("is not a terrain, so it has no heights to set; replace() gives it another geometry");
    const Terrain& terrain = *model.terrain();
    if (model.file())
        refuse("is a terrain in a cooked file, whose heights are fixed; make_terrain() makes one in memory from its "
               "heights");
    if (std::uint64_t(where.columns) * where.rows != count)
        refuse(fmt::format("{} heights are given for {} columns and {} rows", count, where.columns, where.rows));
    if (where.column > terrain.columns() || where.columns > terrain.columns() - where.column ||
        where.row > terrain.rows() || where.rows > terrain.rows() - where.row)
        refuse(fmt::format("{} columns and {} rows of heights from column {}, row {} are given, but the terrain has {} "
                           "columns and {} rows",
                           where.columns, where.rows, where.column, where.row, terrain.columns(), terrain.rows()));
}

void WorldImpl::set_heights(ModelId id, const TerrainRectangle& where, std::span<const double> heights)
{
    if (heights.empty()) return;
    if (!models.owns_heights(id)) {
        examine_heights(title_of(models[id].geometry()), *models[id].terrain(), where,
                        heights); // before anything changes
        replace(id, models.own(id));
        models.own_heights(id);
    }
    const HeightMove moved = models.move_heights(id, title_of(models[id].geometry()), where, heights);
    if (!moved.any()) return;
    each_body(id, [&](std::uint32_t slot) {
        // The surface has moved to where it was not, if a cell appeared there.
        moved.holes ? bodies.set_model(slot, &models[id], id) : bodies.deform(slot, moved.distance);
    });
    changed();
}

ModelId Models::add(GeometryData geometry, std::string name)
{
    return world_->models.add(checked(std::move(name), std::move(geometry)));
}
ModelId Models::add(std::shared_ptr<const Geometry> geometry)
{
    return world_->models.add(checked(std::move(geometry)));
}
void Models::replace(ModelId model, GeometryData geometry)
{
    world_->replace(model, checked(world_->model_of(model).geometry().name, std::move(geometry)));
}
void Models::replace(ModelId model, std::shared_ptr<const Geometry> geometry)
{
    world_->replace(model, checked(std::move(geometry)));
}

void Models::set_vertices(ModelId model, std::span<const Eigen::Vector3d> positions)
{
    const std::size_t vertices = world_->check_vertices(model).vertices.size();
    if (positions.size() != vertices)
        throw Error(ErrorKind::usage,
                    fmt::format("{}: {} positions are given for {} vertices; give one for each vertex, or the first "
                                "vertex of a range",
                                text_of("model", model.slot, model.generation), positions.size(), vertices));
    world_->set_vertices(model, 0, positions);
}
void Models::set_vertices(ModelId model, std::size_t first, std::span<const Eigen::Vector3d> positions)
{
    const std::size_t vertices = world_->check_vertices(model).vertices.size();
    if (first > vertices || positions.size() > vertices - first)
        throw Error(ErrorKind::usage,
                    fmt::format("{}: {} positions from vertex {} are given, but the mesh has {} vertices",
                                text_of("model", model.slot, model.generation), positions.size(), first, vertices));
    world_->set_vertices(model, first, positions);
}

void Models::set_heights(ModelId terrain, const TerrainRectangle& where, std::span<const double> heights)
{
    world_->check_heights(terrain, where, heights.size());
    world_->set_heights(terrain, where, heights);
}

void Models::edit(ModelId map, const std::function<void(OccupancyMap&)>& change)
{
    if (!world_->model_of(map).map())
        throw Error(ErrorKind::usage, text_of("model", map.slot, map.generation) + ": is not an occupancy map");
    const std::shared_ptr<Geometry> own = world_->models.own(map);
    try {
        change(std::get<OccupancyMap>(own->data));
    } catch (...) { // cells may have changed
        world_->replace(map, own);
        throw;
    }
    world_->replace(map, own);
}

void Models::remove(ModelId model)
{
    WorldImpl& p = *world_;
    p.model_of(model);
    if (model.slot < p.users.size() && p.users[model.slot])
        throw Error(ErrorKind::usage, fmt::format("{}: {} bodies use it; remove them first",
                                                  text_of("model", model.slot, model.generation), p.users[model.slot]));
    p.models.remove(model);
}

bool Models::contains(ModelId model) const
{
    return world_->models.valid(model);
}
std::size_t Models::size() const
{
    return world_->models.size();
}
ModelId Models::at(std::uint32_t slot) const
{
    return world_->models.alive(slot) ? world_->models.id(slot) : ModelId{};
}
const Geometry& Models::geometry(ModelId model) const
{
    return world_->model_of(model).geometry();
}
bool Models::closed(ModelId model) const
{
    return world_->model_of(model).closed();
}
Aabb Models::bounds(ModelId model, const RigidMotion& motion) const
{
    const PoseBounds& bounds = world_->model_of(model).bounds();
    const Eigen::Isometry3d end = motion.pose(1);
    WorldImpl::check_pose("", end);
    const bool tight = world_->runs(StageId::bounds);
    if (!motion.rests()) return bounds.box(motion, tight);
    return tight ? bounds.box(end) : bounds.sphere_box(end);
}

} // namespace oncollide
