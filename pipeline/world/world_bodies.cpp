// World: bodies.
#include <oncollide/pipeline/world/world_impl.hpp>

#include <algorithm>
#include <new>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>

namespace oncollide {

namespace {

void same_length(const char* what, std::size_t a, std::size_t b)
{
    if (a != b)
        throw Error(ErrorKind::usage,
                    fmt::format("{}: spans of {} and {} elements; must have the same length", what, a, b));
}

} // namespace

BodyId World::add_body(const BodySpec& body)
{
    impl().check_body(body);
    impl_->changed();
    return impl_->add_checked(body);
}
void World::add_bodies(std::span<const BodySpec> bodies, std::span<BodyId> ids)
{
    same_length("add_bodies", bodies.size(), ids.size());
    for (const BodySpec& body : bodies) impl().check_body(body);
    impl_->changed();
    for (std::size_t i = 0; i < bodies.size(); ++i) ids[i] = impl_->add_checked(bodies[i]);
}
void World::reserve_bodies(std::size_t bodies)
{
    constexpr std::size_t most = std::size_t{1} << 32; // slots
    if (bodies >= most)
        throw Error(ErrorKind::usage,
                    fmt::format("reserve_bodies: {} bodies: a World holds up to {}", bodies, most - 1));
    impl().bodies.reserve(bodies);
}
void World::remove_body(BodyId body)
{
    remove_bodies({&body, 1});
}
void World::remove_bodies(std::span<const BodyId> bodies)
{
    for (const BodyId body : bodies) impl().slot_of(body);
    std::vector<std::uint32_t> slots;
    for (const BodyId body : bodies) slots.push_back(body.slot);
    if (slots.size() > 1) {
        std::vector<std::uint32_t> sorted = slots;
        std::sort(sorted.begin(), sorted.end());
        if (const auto twice = std::adjacent_find(sorted.begin(), sorted.end()); twice != sorted.end())
            throw Error(ErrorKind::usage, fmt::format("remove_bodies: body {} is listed twice", *twice));
    }
    impl_->changed();
    for (std::uint32_t slot : slots) impl_->remove_checked(slot);
}
bool World::contains(BodyId body) const
{
    return impl().bodies.valid(body);
}
std::size_t World::size() const
{
    return impl().bodies.size();
}

void World::set_pose(BodyId body, const Eigen::Isometry3d& pose)
{
    const std::uint32_t slot = impl().slot_of(body);
    impl_->check_pose(slot, pose);
    impl_->changed();
    impl_->bodies.set_pose(slot, pose);
}
void World::set_poses(std::span<const BodyId> bodies, std::span<const Eigen::Isometry3d> poses)
{
    Impl& p = impl();
    same_length("set_poses", bodies.size(), poses.size());
    for (std::size_t i = 0; i < bodies.size(); ++i) p.check_pose(p.slot_of(bodies[i]), poses[i]);
    p.changed();
    for (std::size_t i = 0; i < bodies.size(); ++i) p.bodies.set_pose(bodies[i].slot, poses[i]);
}
void World::set_motion(BodyId body, const Eigen::Isometry3d& to, MotionPath path)
{
    set_motions({&body, 1}, {&to, 1}, path);
}
void World::set_motions(std::span<const BodyId> bodies, std::span<const Eigen::Isometry3d> to, MotionPath path)
{
    Impl& p = impl();
    same_length("set_motions", bodies.size(), to.size());
    for (std::size_t i = 0; i < bodies.size(); ++i) p.check_pose(p.slot_of(bodies[i]), to[i]);
    p.changed();
    for (std::size_t i = 0; i < bodies.size(); ++i)
        p.bodies.set_motion(bodies[i].slot, {p.bodies.pose(bodies[i].slot), to[i], path});
}
void World::set_motion(BodyId body, const RigidMotion& motion)
{
    const std::uint32_t slot = impl().slot_of(body);
    impl_->changed();
    impl_->bodies.set_motion(slot, motion);
}
void World::set_sweep_options(const SweepOptions& options)
{
    Impl::check_sweep("set_sweep_options", options);
    impl().frame.sweep_options = options;
}
void World::set_static(BodyId body, bool is_static)
{
    const std::uint32_t slot = impl().slot_of(body);
    impl_->changed();
    impl_->bodies.set_static(slot, is_static);
}
void World::sleep(std::span<const BodyId> bodies)
{
    for (const BodyId body : bodies) impl().slot_of(body);
    for (const BodyId body : bodies) impl_->bodies.set_asleep(body.slot, true);
}
void World::wake(std::span<const BodyId> bodies)
{
    for (const BodyId body : bodies) impl().slot_of(body);
    for (const BodyId body : bodies) impl_->bodies.set_asleep(body.slot, false);
}
void World::set_layers(BodyId body, std::uint32_t layer, std::uint32_t mask)
{
    const std::uint32_t slot = impl().slot_of(body);
    impl_->changed();
    impl_->bodies.set_filter(slot, layer, mask, impl_->bodies.group(slot));
}
void World::set_group(BodyId body, std::uint32_t group)
{
    const std::uint32_t slot = impl().slot_of(body);
    impl_->changed();
    impl_->bodies.set_filter(slot, impl_->bodies.layer(slot), impl_->bodies.mask(slot), group);
}
void World::set_model(BodyId body, ModelId model)
{
    Impl& p = impl();
    const std::uint32_t slot = p.slot_of(body);
    p.check_body({.model = model});
    if (p.users.size() <= model.slot) p.users.resize(model.slot + std::size_t{1});
    --p.users[p.bodies.model_id(slot).slot], ++p.users[model.slot];
    p.changed();
    p.bodies.set_model(slot, &p.models[model], model);
}
void World::set_user(BodyId body, std::uint64_t user)
{
    impl().bodies.set_user(impl_->slot_of(body), user);
}
void World::exclude(BodyId a, BodyId b)
{
    const std::uint32_t slot_a = impl().slot_of(a), slot_b = impl_->slot_of(b);
    if (slot_a == slot_b) throw Error(ErrorKind::usage, impl_->label(slot_a) + ": cannot be excluded from itself");
    impl_->bodies.exclude(slot_a, slot_b);
}
void World::include(BodyId a, BodyId b)
{
    impl().bodies.include(impl_->slot_of(a), impl_->slot_of(b));
}

const Eigen::Isometry3d& World::pose(BodyId body) const
{
    return impl().bodies.pose(impl_->slot_of(body));
}
ModelId World::model(BodyId body) const
{
    return impl().bodies.model_id(impl_->slot_of(body));
}
std::uint64_t World::user(BodyId body) const
{
    return impl().bodies.user(impl_->slot_of(body));
}
bool World::is_static(BodyId body) const
{
    return impl().bodies.is_static(impl_->slot_of(body));
}
bool World::is_asleep(BodyId body) const
{
    return impl().bodies.is_asleep(impl_->slot_of(body));
}
BodyId World::body_at(std::uint32_t slot) const
{
    return impl().bodies.alive(slot) ? impl().bodies.id(slot) : BodyId{};
}
std::uint32_t World::layer(BodyId body) const
{
    return impl().bodies.layer(impl().slot_of(body));
}
std::uint32_t World::mask(BodyId body) const
{
    return impl().bodies.mask(impl().slot_of(body));
}
std::uint32_t World::group(BodyId body) const
{
    return impl().bodies.group(impl().slot_of(body));
}
bool World::excluded(BodyId a, BodyId b) const
{
    return impl().bodies.excluded(impl().slot_of(a), impl_->slot_of(b));
}

} // namespace oncollide
