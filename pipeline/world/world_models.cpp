// World: its models.
#include <oncollide/pipeline/world/world_impl.hpp>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>

namespace oncollide {

namespace {

constexpr const char* kind_names[] = {"mesh", "shape", "map", "terrain", "mesh"}; // names of the alternatives

std::shared_ptr<const Geometry> checked(std::string name, GeometryData data)
{
    check_geometry(name.empty() ? kind_names[data.index()] : name, data);
    return std::make_shared<const Geometry>(Geometry{std::move(name), std::move(data), {}});
}
std::shared_ptr<const Geometry> checked(std::shared_ptr<const Geometry> geometry)
{
    if (!geometry) throw Error(ErrorKind::usage, "model: no geometry given");
    check_geometry(geometry->name.empty() ? "model" : geometry->name, geometry->data);
    return geometry;
}

} // namespace

void WorldImpl::replace(ModelId id, std::shared_ptr<const Geometry> geometry)
{
    model_of(id);
    if (settings.mode == Mode::solid && id.slot < users.size() && users[id.slot]) check_inside(Model(geometry));
    models.replace(id, std::move(geometry));
    std::uint32_t left = id.slot < users.size() ? users[id.slot] : 0;
    for (std::uint32_t slot = 0; left > 0; ++slot)
        if (bodies.alive(slot) && bodies.model_id(slot) == id) bodies.set_model(slot, &models[id], id), --left;
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
