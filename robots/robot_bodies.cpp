// A robot as bodies of a World, and attached objects.
#include <oncollide/robots/robot_impl.hpp>

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include <oncollide/pipeline/world/world_access.hpp>

namespace oncollide {

namespace {

constexpr std::size_t spheres_of_object = 16;

} // namespace

void Robot::Impl::refuse_with_bodies(const char* call) const
{
    if (!bodies.empty()) throw Error(ErrorKind::usage, std::string("robot: ") + call + ": remove_bodies() comes first");
}

std::uint32_t Robot::attach(World& world, std::uint32_t link, ModelId model, const Eigen::Isometry3d& pose,
                            std::span<const std::uint32_t> touching)
{
    Impl& p = *impl_;
    p.check_world(world);
    p.refuse_with_bodies("attach");
    p.check_link("attach", link);
    for (const std::uint32_t other : touching) p.check_link("attach", other);
    p.check_pose("attached object", pose);
    WorldAccess::check_inside(world, model);
    const Aabb box = world.models().bounds(model, Eigen::Isometry3d::Identity());
    p.add_part(link, model, pose, cover_box(box, spheres_of_object), touching);
    p.add_group(static_cast<std::uint32_t>(p.parts.size() - 1));
    p.take_in_groups();
    return static_cast<std::uint32_t>(p.parts.size() - 1 - p.attached_from);
}

void Robot::detach_all()
{
    Impl& p = *impl_;
    p.refuse_with_bodies("detach_all");
    p.parts.resize(p.attached_from), p.spheres.resize(p.spheres_of_links);
    std::erase_if(p.groups, [&](const Impl::Group& group) { return group.first >= p.attached_from; });
    p.take_in_groups();
}

void Robot::add_bodies(World& world, const BodySpec& given)
{
    Impl& p = *impl_;
    p.check_world(world);
    p.refuse_with_bodies("add_bodies");
    std::vector<Eigen::Isometry3d> links(p.description.links.size(), Eigen::Isometry3d::Identity());
    p.tree.link_poses(neutral().data(), p.base, links.data());
    std::vector<BodySpec> specs;
    for (const Impl::Part& part : p.parts) {
        BodySpec& spec = specs.emplace_back(given);
        spec.model = part.model, spec.pose = p.pose_of(part, links.data());
    }
    std::vector<BodyId> bodies(specs.size());
    world.bodies().add(specs, bodies);
    p.bodies = std::move(bodies);
    std::set<std::pair<std::uint32_t, std::uint32_t>> tested;
    for (const Impl::PartPair& pair : p.pairs) tested.insert({pair.a, pair.b});
    for (std::uint32_t b = 0; b < p.parts.size(); ++b)
        for (std::uint32_t a = 0; a < b; ++a)
            if (!tested.contains({a, b})) world.bodies().exclude(p.bodies[a], p.bodies[b]);
    for (const auto& [link, body] : p.allowed_bodies)
        for (std::uint32_t part = 0; part < p.parts.size(); ++part)
            if (p.parts[part].link == link && world.bodies().contains(body))
                world.bodies().exclude(p.bodies[part], body);
}

void Robot::set_joints(World& world, std::span<const double> configuration)
{
    Impl& p = *impl_;
    p.check_world(world);
    check_configuration(configuration, false);
    if (p.bodies.empty()) throw Error(ErrorKind::usage, "robot: set_joints: add_bodies() comes first");
    std::vector<Eigen::Isometry3d> links(p.description.links.size(), Eigen::Isometry3d::Identity()), poses;
    p.tree.link_poses(configuration.data(), p.base, links.data());
    for (const Impl::Part& part : p.parts) poses.push_back(p.pose_of(part, links.data()));
    world.bodies().set_pose(p.bodies, poses);
}

void Robot::remove_bodies(World& world)
{
    impl_->check_world(world);
    std::erase_if(impl_->bodies, [&](BodyId body) { return !world.bodies().contains(body); }); // removed by others
    world.bodies().remove(impl_->bodies);
    impl_->bodies.clear();
}

std::span<const BodyId> Robot::bodies() const
{
    return impl_->bodies;
}

std::uint32_t Robot::link_of(std::size_t body) const
{
    if (body >= impl_->parts.size()) throw Error(ErrorKind::usage, "robot: there is no such body");
    return impl_->parts[body].link;
}

} // namespace oncollide
