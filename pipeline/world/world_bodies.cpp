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

BodyId Bodies::add(const BodySpec& body)
{
    world_->check_body(body);
    world_->changed();
    return world_->add_checked(body);
}
void Bodies::add(std::span<const BodySpec> bodies, std::span<BodyId> ids)
{
    same_length("add", bodies.size(), ids.size());
    for (const BodySpec& body : bodies) world_->check_body(body);
    world_->changed();
    for (std::size_t i = 0; i < bodies.size(); ++i) ids[i] = world_->add_checked(bodies[i]);
}
void Bodies::reserve(std::size_t bodies)
{
    constexpr std::uint64_t most = std::uint64_t{1} << 32; // slots
    if (std::uint64_t{bodies} >= most)
        throw Error(ErrorKind::usage, fmt::format("reserve: {} bodies: a World holds up to {}", bodies, most - 1));
    world_->bodies.reserve(bodies);
}
void Bodies::remove(BodySpan bodies)
{
    for (const BodyId body : bodies) world_->slot_of(body);
    if (bodies.size() > 1) {
        std::vector<BodyId> sorted(bodies.begin(), bodies.end());
        std::ranges::sort(sorted);
        if (const auto twice = std::ranges::adjacent_find(sorted); twice != sorted.end())
            throw Error(ErrorKind::usage, fmt::format("remove: body {} is listed twice", twice->slot));
    }
    world_->changed();
    for (const BodyId body : bodies) world_->remove_checked(body.slot);
}
bool Bodies::contains(BodyId body) const
{
    return world_->bodies.valid(body);
}
std::size_t Bodies::size() const
{
    return world_->bodies.size();
}
BodyId Bodies::at(std::uint32_t slot) const
{
    return world_->bodies.alive(slot) ? world_->bodies.id(slot) : BodyId{};
}

const Eigen::Isometry3d& Bodies::pose(BodyId body) const
{
    return world_->bodies.pose(world_->slot_of(body));
}
void Bodies::set_pose(BodyId body, const Eigen::Isometry3d& pose)
{
    const std::uint32_t slot = world_->slot_of(body);
    world_->check_pose(slot, pose);
    world_->changed();
    world_->bodies.set_pose(slot, pose);
}
void Bodies::set_pose(std::span<const BodyId> bodies, std::span<const Eigen::Isometry3d> poses)
{
    WorldImpl& p = *world_;
    same_length("set_pose", bodies.size(), poses.size());
    for (std::size_t i = 0; i < bodies.size(); ++i) p.check_pose(p.slot_of(bodies[i]), poses[i]);
    p.changed();
    for (std::size_t i = 0; i < bodies.size(); ++i) p.bodies.set_pose(bodies[i].slot, poses[i]);
}
void Bodies::set_motion(BodyId body, const Eigen::Isometry3d& to, MotionPath path)
{
    set_motion({&body, 1}, {&to, 1}, path);
}
void Bodies::set_motion(std::span<const BodyId> bodies, std::span<const Eigen::Isometry3d> to, MotionPath path)
{
    WorldImpl& p = *world_;
    same_length("set_motion", bodies.size(), to.size());
    for (std::size_t i = 0; i < bodies.size(); ++i) p.check_pose(p.slot_of(bodies[i]), to[i]);
    p.changed();
    for (std::size_t i = 0; i < bodies.size(); ++i)
        p.bodies.set_motion(bodies[i].slot, {p.bodies.pose(bodies[i].slot), to[i], path});
}
void Bodies::set_motion(BodyId body, const RigidMotion& motion)
{
    const std::uint32_t slot = world_->slot_of(body);
    world_->changed();
    world_->bodies.set_motion(slot, motion);
}

bool Bodies::is_static(BodyId body) const
{
    return world_->bodies.is_static(world_->slot_of(body));
}
void Bodies::set_static(BodySpan bodies, bool is_static)
{
    for (const BodyId body : bodies) world_->slot_of(body);
    world_->changed();
    for (const BodyId body : bodies) world_->bodies.set_static(body.slot, is_static);
}
void Bodies::sleep(BodySpan bodies)
{
    for (const BodyId body : bodies) world_->slot_of(body);
    for (const BodyId body : bodies) world_->bodies.set_asleep(body.slot, true);
}
void Bodies::wake(BodySpan bodies)
{
    for (const BodyId body : bodies) world_->slot_of(body);
    for (const BodyId body : bodies) world_->bodies.set_asleep(body.slot, false);
}
bool Bodies::is_asleep(BodyId body) const
{
    return world_->bodies.is_asleep(world_->slot_of(body));
}

CollisionFilter Bodies::filter(BodyId body) const
{
    const std::uint32_t slot = world_->slot_of(body);
    const BodyTable& bodies = world_->bodies;
    return {bodies.layer(slot), bodies.mask(slot), bodies.group(slot)};
}
void Bodies::set_filter(BodySpan bodies, const CollisionFilter& filter)
{
    for (const BodyId body : bodies) world_->slot_of(body);
    world_->changed();
    for (const BodyId body : bodies) world_->bodies.set_filter(body.slot, filter.layer, filter.mask, filter.group);
}
void Bodies::exclude(BodyId a, BodyId b)
{
    const std::uint32_t slot_a = world_->slot_of(a), slot_b = world_->slot_of(b);
    if (slot_a == slot_b) throw Error(ErrorKind::usage, world_->label(slot_a) + ": cannot be excluded from itself");
    world_->bodies.exclude(slot_a, slot_b);
}
void Bodies::include(BodyId a, BodyId b)
{
    world_->bodies.include(world_->slot_of(a), world_->slot_of(b));
}
bool Bodies::excluded(BodyId a, BodyId b) const
{
    return world_->bodies.excluded(world_->slot_of(a), world_->slot_of(b));
}

ModelId Bodies::model(BodyId body) const
{
    return world_->bodies.model_id(world_->slot_of(body));
}
void Bodies::set_model(BodySpan bodies, ModelId model)
{
    WorldImpl& p = *world_;
    for (const BodyId body : bodies) p.slot_of(body);
    p.check_body({.model = model});
    if (p.users.size() <= model.slot) p.users.resize(model.slot + std::size_t{1});
    p.changed();
    for (const BodyId body : bodies) {
        --p.users[p.bodies.model_id(body.slot).slot], ++p.users[model.slot];
        p.bodies.set_model(body.slot, &p.models[model], model);
    }
}
std::uint64_t Bodies::user(BodyId body) const
{
    return world_->bodies.user(world_->slot_of(body));
}
void Bodies::set_user(BodyId body, std::uint64_t user)
{
    world_->bodies.set_user(world_->slot_of(body), user);
}

} // namespace oncollide
