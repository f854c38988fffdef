// World: construction, checks of arguments, models.
#include <oncollide/pipeline/world/world_impl.hpp>

#include <atomic>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/pipeline/world/query_worker.hpp> // for the destructor of Impl
#include <oncollide/pipeline/world/world_access.hpp>

namespace oncollide {

namespace {

std::shared_ptr<const Geometry> share(std::string name, GeometryData data)
{
    return std::make_shared<const Geometry>(Geometry{std::move(name), std::move(data), {}});
}

std::string name_or(const std::string& name, const char* kind)
{
    return name.empty() ? std::string(kind) : name;
}

std::shared_ptr<const Geometry> checked(std::string name, Mesh mesh)
{
    check_mesh(name_or(name, "mesh"), mesh);
    return share(std::move(name), std::move(mesh));
}
std::shared_ptr<const Geometry> checked(std::string name, Shape shape)
{
    check_shape(name_or(name, "shape"), shape);
    return share(std::move(name), std::move(shape));
}
std::shared_ptr<const Geometry> checked(std::string name, OccupancyMap map)
{
    return share(std::move(name), std::move(map));
}
std::shared_ptr<const Geometry> checked(std::string name, Terrain terrain)
{
    return share(std::move(name), std::move(terrain));
}
std::shared_ptr<const Geometry> checked(std::shared_ptr<const Geometry> geometry)
{
    if (!geometry) throw Error(ErrorKind::usage, "model: no geometry given");
    check_geometry(name_or(geometry->name, "model"), geometry->data);
    return geometry;
}

std::string text_of(const char* what, std::uint32_t slot, std::uint32_t generation)
{
    return fmt::format("{} {} (generation {})", what, slot, generation);
}

/// A tag that differs from World to World: 1 to 65535, then from 1 again.
std::uint16_t next_tag()
{
    static std::atomic<std::uint32_t> made{0};
    return static_cast<std::uint16_t>(1 + made.fetch_add(1, std::memory_order_relaxed) % 0xffff);
}

/// Throws unless `id` could be of the World `tag`. `maker` returns such ids.
template <class Id>
void check_origin(const char* what, const char* maker, Id id, std::uint16_t tag)
{
    if (!id) throw Error(ErrorKind::usage, fmt::format("{}: the id is null; {} returns ids", what, maker));
    if (id.world != tag) throw Error(ErrorKind::usage, fmt::format("{} {}: the id is of another World", what, id.slot));
}

} // namespace

World::Impl::Impl(const Settings& s, std::unique_ptr<OcclusionBackend> backend, std::string note)
    : settings(s), tag(next_tag()), models(settings, std::move(backend), tag), bodies(tag), frame(settings),
      backend_note(std::move(note))
{
    frame.context.threads = thread_count(settings);
}

World::Impl& World::impl() const
{
    if (!impl_) throw Error(ErrorKind::usage, "World: it was moved from; only assign to it or destroy it");
    return *impl_;
}

std::uint32_t World::Impl::slot_of(BodyId id) const
{
    if (bodies.valid(id)) return id.slot;
    check_origin("body", "add_body()", id, tag);
    throw Error(ErrorKind::usage,
                text_of("body", id.slot, id.generation) +
                    (id.slot < bodies.slots() ? ": was removed; its id is stale" : ": does not exist"));
}

Model& World::Impl::model_of(ModelId id)
{
    if (models.valid(id)) return models[id];
    check_origin("model", "add()", id, tag);
    throw Error(ErrorKind::usage,
                text_of("model", id.slot, id.generation) +
                    (id.slot < models.slots() ? ": was removed; its id is stale" : ": does not exist"));
}

Model& World::Impl::check_model(ModelId id)
{
    Model& model = model_of(id);
    if (model.file() && !reads_on_demand(settings)) model.read_all();
    check_inside(model);
    return model;
}

void World::Impl::check_inside(const Model& model) const
{
    if (settings.mode == Mode::solid && !settings.open_as_surface && model.is_open_mesh())
        refuse_open_mesh(name_or(model.geometry().name, "mesh"), *model.mesh());
}

std::string WorldAccess::why_refused(const Eigen::Isometry3d& pose)
{
    std::string why = why_not_rigid(pose);
    if (why.empty() && !(pose.translation().cwiseAbs().maxCoeff() <= 1e15)) why = "the pose is beyond 1e15 m";
    return why;
}

void World::Impl::check_pose(const char* whose, const Eigen::Isometry3d& pose)
{
    if (const std::string why = WorldAccess::why_refused(pose); !why.empty())
        throw Error(ErrorKind::bad_data, whose + why);
}

void World::Impl::check_pose(std::uint32_t slot, const Eigen::Isometry3d& pose)
{
    if (const std::string why = WorldAccess::why_refused(pose); !why.empty())
        throw Error(ErrorKind::bad_data, fmt::format("{}: {}", label(slot), why));
}

void World::Impl::check_body(const BodySpec& body)
{
    const Model& model = model_of(body.model);
    check_pose("new body: ", body.pose);
    if (!reads_on_demand(settings)) model.read_all(); // now rather than in the middle of a frame
    check_inside(model);
}

BodyId World::Impl::add_checked(const BodySpec& body)
{
    Model& model = models[body.model];
    if (users.size() <= body.model.slot) users.resize(body.model.slot + std::size_t{1});
    ++users[body.model.slot];
    return bodies.id(
        bodies.add({&model, body.model, body.pose, body.layer, body.mask, body.group, body.user, body.is_static}));
}

void World::Impl::remove_checked(std::uint32_t slot)
{
    --users[bodies.model_id(slot).slot];
    bodies.remove(slot);
}

void World::Impl::replace(ModelId id, std::shared_ptr<const Geometry> geometry)
{
    model_of(id);
    if (settings.mode == Mode::solid && id.slot < users.size() && users[id.slot]) check_inside(Model(geometry));
    models.replace(id, std::move(geometry));
    std::uint32_t left = id.slot < users.size() ? users[id.slot] : 0;
    for (std::uint32_t slot = 0; left > 0; ++slot)
        if (bodies.alive(slot) && bodies.model_id(slot) == id) bodies.set_model(slot, &models[id], id), --left;
    changed();
}

const OccupancyMap& World::Impl::map_of(ModelId id)
{
    const Model& model = model_of(id);
    if (!model.map())
        throw Error(ErrorKind::usage, text_of("model", id.slot, id.generation) + ": is not an occupancy map");
    return *model.map();
}

template <class Change>
void World::Impl::change_map(ModelId id, Change change)
{
    map_of(id);
    const std::shared_ptr<Geometry> own = models.own(id);
    change(std::get<OccupancyMap>(own->data));
    replace(id, own);
}

World::World(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

ModelId World::add(Mesh mesh, std::string name)
{
    return impl().models.add(checked(std::move(name), std::move(mesh)));
}
ModelId World::add(Shape shape, std::string name)
{
    return impl().models.add(checked(std::move(name), std::move(shape)));
}
ModelId World::add(OccupancyMap map, std::string name)
{
    return impl().models.add(checked(std::move(name), std::move(map)));
}
ModelId World::add(Terrain terrain, std::string name)
{
    return impl().models.add(checked(std::move(name), std::move(terrain)));
}
ModelId World::add(std::shared_ptr<const CookedMesh> mesh, std::string name)
{
    if (!mesh) throw Error(ErrorKind::usage, "model: no mesh given");
    return impl().models.add(share(std::move(name), std::move(mesh)));
}
ModelId World::add(std::shared_ptr<const Geometry> geometry)
{
    return impl().models.add(checked(std::move(geometry)));
}
void World::replace(ModelId model, Mesh mesh)
{
    impl().replace(model, checked(impl_->model_of(model).geometry().name, std::move(mesh)));
}
void World::replace(ModelId model, Shape shape)
{
    impl().replace(model, checked(impl_->model_of(model).geometry().name, std::move(shape)));
}
void World::replace(ModelId model, OccupancyMap map)
{
    impl().replace(model, checked(impl_->model_of(model).geometry().name, std::move(map)));
}
void World::replace(ModelId model, Terrain terrain)
{
    impl().replace(model, checked(impl_->model_of(model).geometry().name, std::move(terrain)));
}
void World::replace(ModelId model, std::shared_ptr<const Geometry> geometry)
{
    impl().replace(model, checked(std::move(geometry)));
}
void World::set_cells(ModelId map, std::span<const Eigen::Vector3d> points, CellState state)
{
    impl().change_map(map, [&](OccupancyMap& own) { own.set(points, state); });
}
void World::set_cells(ModelId map, const Aabb& box, CellState state)
{
    impl().change_map(map, [&](OccupancyMap& own) { own.set(box, state); });
}
void World::replace_cells(ModelId map, const Aabb& box, const OccupancyMap& by)
{
    impl().change_map(map, [&](OccupancyMap& own) { own.replace(box, by); });
}
void World::insert_scan(ModelId map, std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& origin,
                        double max_range)
{
    impl().change_map(map, [&](OccupancyMap& own) { own.insert_scan(points, origin, max_range); });
}
const OccupancyMap& World::map(ModelId map) const
{
    return impl().map_of(map);
}
void World::remove(ModelId model)
{
    Impl& p = impl();
    p.model_of(model);
    if (model.slot < p.users.size() && p.users[model.slot])
        throw Error(ErrorKind::usage, fmt::format("{}: {} bodies use it; remove them first",
                                                  text_of("model", model.slot, model.generation), p.users[model.slot]));
    p.models.remove(model);
}
bool World::closed(ModelId model) const
{
    return impl().model_of(model).closed();
}
bool World::contains(ModelId model) const
{
    return impl().models.valid(model);
}
std::size_t World::models() const
{
    return impl().models.size();
}

ModelId World::model_at(std::uint32_t slot) const
{
    return impl().models.alive(slot) ? impl().models.id(slot) : ModelId{};
}

const Settings& World::settings() const
{
    return impl().settings;
}
Aabb World::bounds(ModelId model, const Eigen::Isometry3d& pose)
{
    PoseBounds& bounds = impl().model_of(model).bounds();
    Impl::check_pose("", pose);
    if (!impl_->runs(StageId::bounds)) return bounds.sphere_box(pose);
    bounds.expect(pose);
    return bounds.box(pose);
}
Aabb World::bounds(ModelId model, const RigidMotion& motion)
{
    PoseBounds& bounds = impl().model_of(model).bounds();
    const bool tight = impl_->runs(StageId::bounds);
    if (tight) bounds.expect(motion);
    return bounds.box(motion, tight);
}
double World::max_error(BodyId a, BodyId b) const
{
    const Bodies& bodies = impl().bodies;
    return impl_->models.max_error(bodies.model(impl_->slot_of(a)), bodies.model(impl_->slot_of(b)));
}
std::string World::Impl::note_on_backend() const
{
    const std::string& lost = models.lost();
    if (!lost.empty()) return "the CPU took over when the GPU was lost: " + lost;
    if (backend_note.empty() && wants_obbs(settings) && models.backend().name().starts_with("gl"))
        return settings.exact == ExactLevel::predicates && exact_runs(settings)
                   ? "the GPU is not used: exact tests on the CPU decide"
                   : "the GPU is not used for pairs of meshes: OBB trees on the CPU separate them";
    return backend_note;
}

} // namespace oncollide
