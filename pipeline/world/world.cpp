// World: construction, checks of arguments, settings.
#include <oncollide/pipeline/settings_rules.hpp>
#include <oncollide/pipeline/world/world_impl.hpp>

#include <atomic>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/rigid.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/pipeline/world/query_worker.hpp> // for the destructor of WorldImpl
#include <oncollide/pipeline/world/world_access.hpp>

namespace oncollide {

namespace {

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

std::string text_of(const char* what, std::uint32_t slot, std::uint32_t generation)
{
    return fmt::format("{} {} (generation {})", what, slot, generation);
}

WorldImpl::WorldImpl(const Settings& s, std::unique_ptr<OcclusionBackend> backend, std::string note)
    : settings(s), tag(next_tag()), models(settings, std::move(backend), tag), bodies(tag), frame(settings),
      backend_note(std::move(note))
{
    frame.context.threads = thread_count(settings);
}

WorldImpl& World::impl() const
{
    if (!impl_) throw Error(ErrorKind::usage, "World: it was moved from; only assign to it or destroy it");
    return *impl_;
}

std::uint32_t WorldImpl::slot_of(BodyId id) const
{
    if (bodies.valid(id)) return id.slot;
    check_origin("body", "Bodies::add()", id, tag);
    throw Error(ErrorKind::usage,
                text_of("body", id.slot, id.generation) +
                    (id.slot < bodies.slots() ? ": was removed; its id is stale" : ": does not exist"));
}

Model& WorldImpl::model_of(ModelId id)
{
    if (models.valid(id)) return models[id];
    check_origin("model", "Models::add()", id, tag);
    throw Error(ErrorKind::usage,
                text_of("model", id.slot, id.generation) +
                    (id.slot < models.slots() ? ": was removed; its id is stale" : ": does not exist"));
}

Model& WorldImpl::check_model(ModelId id)
{
    Model& model = model_of(id);
    if (model.file() && !reads_on_demand(settings)) model.read_all();
    check_inside(model);
    return model;
}

void WorldImpl::check_inside(const Model& model) const
{
    if (settings.mode == Mode::solid && !settings.open_as_surface && model.is_open_mesh())
        refuse_open_mesh(model.geometry().name.empty() ? "mesh" : model.geometry().name, *model.mesh());
}

std::string WorldAccess::why_refused(const Eigen::Isometry3d& pose)
{
    std::string why = why_not_rigid(pose);
    if (why.empty() && !(pose.translation().cwiseAbs().maxCoeff() <= 1e15)) why = "the pose is beyond 1e15 m";
    return why;
}

void WorldImpl::check_pose(const char* whose, const Eigen::Isometry3d& pose)
{
    if (const std::string why = WorldAccess::why_refused(pose); !why.empty())
        throw Error(ErrorKind::bad_data, whose + why);
}

void WorldImpl::check_pose(std::uint32_t slot, const Eigen::Isometry3d& pose)
{
    if (const std::string why = WorldAccess::why_refused(pose); !why.empty())
        throw Error(ErrorKind::bad_data, fmt::format("{}: {}", label(slot), why));
}

void WorldImpl::check_body(const BodySpec& body)
{
    const Model& model = model_of(body.model);
    check_pose("new body: ", body.pose);
    if (!reads_on_demand(settings)) model.read_all(); // now rather than in the middle of a frame
    check_inside(model);
}

BodyId WorldImpl::add_checked(const BodySpec& body)
{
    Model& model = models[body.model];
    if (users.size() <= body.model.slot) users.resize(body.model.slot + std::size_t{1});
    ++users[body.model.slot];
    return bodies.id(
        bodies.add({&model, body.model, body.pose, body.layer, body.mask, body.group, body.user, body.is_static}));
}

void WorldImpl::remove_checked(std::uint32_t slot)
{
    --users[bodies.model_id(slot).slot];
    bodies.remove(slot);
}

World::World(std::unique_ptr<WorldImpl> impl) : impl_(std::move(impl)) {}
World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

Models& World::models()
{
    return impl().models_view;
}
const Models& World::models() const
{
    return impl().models_view;
}
Bodies& World::bodies()
{
    return impl().bodies_view;
}
const Bodies& World::bodies() const
{
    return impl().bodies_view;
}
Pairs World::pairs() const
{
    return Pairs(impl());
}
Space World::space() const
{
    return Space(impl());
}

void World::set_sweep_options(const SweepOptions& options)
{
    WorldImpl::check_sweep("set_sweep_options", options);
    impl().frame.sweep_options = options;
}
const SweepOptions& World::sweep_options() const
{
    return impl().frame.sweep_options;
}
const Settings& World::settings() const
{
    return impl().settings;
}
std::string WorldImpl::note_on_backend() const
{
    const std::string& lost = models.lost();
    std::string note = backend_note;
    if (gpu) return gpu->note();
    if (!lost.empty())
        note = "the CPU took over when the GPU was lost: " + lost;
    else if (note.empty() && wants_obbs(settings) && models.backend().name().starts_with("gl"))
        note = settings.exact == ExactLevel::predicates && exact_runs(settings)
                   ? "the GPU is not used: exact tests on the CPU decide"
                   : "the GPU is not used for pairs of meshes: OBB trees on the CPU separate them";
    if (certified(settings)) return note;
    return "gl-query is not certified: collisions may be missed; for comparison only" +
           (note.empty() ? "" : "; " + note);
}

} // namespace oncollide
