#include <oncollide/pipeline/world/world_access.hpp>

#include <oncollide/narrowphase/gl/walk/mesh_walks.hpp>

#include <oncollide/pipeline/world/world_impl.hpp>

namespace oncollide {

World WorldAccess::make(const Settings& settings, std::unique_ptr<OcclusionBackend> backend)
{
    return World(WorldImpl::make(settings, std::move(backend), {}));
}
World WorldAccess::make(const Settings& settings, const MeshWalkOptions& gpu_options)
{
    return World(WorldImpl::make(settings, nullptr, gpu_options));
}
MeshWalkCounts WorldAccess::gpu_counts(const World& world)
{
    const WorldImpl& p = world.impl();
    return p.gpu ? p.gpu->counts() : MeshWalkCounts{};
}
GpuHostTimes WorldAccess::gpu_host_times(const World& world)
{
    const WorldImpl& p = world.impl();
    return p.gpu ? p.gpu->host() : GpuHostTimes{};
}

std::string WorldAccess::backend(const World& world)
{
    return world.impl().name_of_backend();
}
std::string WorldAccess::renderer(const World& world)
{
    const WorldImpl& p = world.impl();
    return p.gpu ? p.gpu->renderer() : p.models.backend().renderer();
}
std::string WorldAccess::backend_note(const World& world)
{
    return world.impl().note_on_backend();
}

void WorldAccess::replace(World& world, StageId stage,
                          const std::function<std::unique_ptr<Stage>(std::unique_ptr<Stage> old)>& make)
{
    for (std::unique_ptr<Stage>& each : world.impl().stages)
        if (each->id() == stage) each = make(std::move(each));
}

void WorldAccess::grow_ahead(World& world, bool on)
{
    world.impl().models.grow_ahead(on);
}

void WorldAccess::parts_by_poses(World& world)
{
    world.impl().frame.parts_by_poses = true;
}

Aabb WorldAccess::step_bounds(World& world, ModelId model, const Eigen::Isometry3d& pose)
{
    PoseBounds& bounds = world.impl().model_of(model).bounds();
    WorldImpl::check_pose("", pose);
    if (!world.impl().runs(StageId::bounds)) return bounds.sphere_box(pose);
    bounds.expect(pose);
    return bounds.box(pose);
}
Aabb WorldAccess::step_bounds(World& world, ModelId model, const RigidMotion& motion)
{
    PoseBounds& bounds = world.impl().model_of(model).bounds();
    const bool tight = world.impl().runs(StageId::bounds);
    if (tight) bounds.expect(motion);
    return bounds.box(motion, tight);
}

void WorldAccess::check_inside(const World& world, const std::shared_ptr<const Geometry>& geometry)
{
    if (world.settings().mode == Mode::solid) world.impl().check_inside(Model(geometry));
}

void WorldAccess::check_inside(const World& world, ModelId model)
{
    world.impl().check_model(model);
}

const Ocst* WorldAccess::tree(const World& world, ModelId model)
{
    return world.impl().model_of(model).spheres();
}

} // namespace oncollide
