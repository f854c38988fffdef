#include <oncollide/robots/robot_impl.hpp>

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include <oncollide/base/rigid.hpp>
#include <oncollide/base/text/near_word.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/pipeline/world/world_access.hpp>
#include <oncollide/robots/description_fault.hpp>

namespace oncollide {

namespace {

constexpr std::size_t spheres_each = 16; // per geometry, to rule out pairs

[[noreturn]] void fail(const std::string& what)
{
    throw Error(ErrorKind::usage, "robot: " + what);
}

/// Spheres that contain the geometry: the surface of a mesh, or a solid.
std::vector<CoverSphere> cover(const Geometry& geometry, bool solid)
{
    const Mesh* const mesh = std::get_if<Mesh>(&geometry.data);
    const Shape* const shape = std::get_if<Shape>(&geometry.data);
    if (const Sphere* const sphere = shape ? std::get_if<Sphere>(shape) : nullptr)
        return {{Eigen::Vector3d::Zero(), sphere->radius * (1 + 1e-12)}};
    return mesh && !solid ? cover_triangles(*mesh, spheres_each) : cover_box(bounds_of(geometry), spheres_each);
}

double limited(const RobotJoint& joint, double value)
{
    return std::min(std::max(value, joint.lower), joint.upper);
}

} // namespace

/// The description as Robot keeps it: excluded pairs are a < b, sorted.
RobotDescription Robot::Impl::checked(RobotDescription given)
{
    check_description(given);
    for (auto& [a, b] : given.excluded)
        if (a > b) std::swap(a, b);
    std::ranges::sort(given.excluded);
    return given;
}

Robot::Impl::Impl(World& world, RobotDescription given, const Eigen::Isometry3d& base_pose)
    : description(checked(std::move(given))), tree(description), base(base_pose)
{
    check_pose("base", base);
    for (const RobotLink& link : description.links)
        for (const LinkGeometry& collision : link.collision) try {
                WorldAccess::check_inside(world, collision.geometry);
            } catch (const Error& error) {
                refuse(fmt::format("robot '{}': link '{}'", printable(description.name), printable(link.name)),
                       error.what());
            }
    const bool solid = world.settings().mode == Mode::solid;
    std::map<const Geometry*, ModelId> models;
    std::map<const Mesh*, std::shared_ptr<const PartSolids>> solids;
    for (std::uint32_t i = 0; i < description.links.size(); ++i) {
        const auto first = static_cast<std::uint32_t>(parts.size());
        for (const LinkGeometry& collision : description.links[i].collision) {
            ModelId& model = models[collision.geometry.get()];
            if (!model) model = world.models().add(collision.geometry);
            add_part(i, model, collision.pose, cover(*collision.geometry, solid), {});
            if (const Mesh* const mesh = std::get_if<Mesh>(&collision.geometry->data)) {
                std::shared_ptr<const PartSolids>& own = solids[mesh];
                if (!own) own = std::make_shared<const PartSolids>(*mesh);
                parts.back().solids = own;
            }
        }
        if (first < parts.size()) add_group(first);
    }
    for (const RobotJoint& joint : description.joints)
        for (int n = 0; n < numbers_of(joint); ++n)
            neutral.push_back(joint.kind == JointKind::floating ? n == 6 : limited(joint, 0));
    attached_from = parts.size(), spheres_of_links = spheres.size();
    if (parts.empty()) refuse(fmt::format("robot '{}'", printable(description.name)), "no link has collision geometry");
    any_model = parts.front().model;
    take_in_groups();
}

void Robot::Impl::add_part(std::uint32_t link, ModelId model, const Eigen::Isometry3d& pose,
                           std::vector<CoverSphere> cover, std::span<const std::uint32_t> touching)
{
    for (CoverSphere& sphere : cover) sphere.centre = pose * sphere.centre;
    const PartSpheres own{static_cast<std::uint32_t>(spheres.size()), static_cast<std::uint32_t>(cover.size()),
                          around_spheres(cover)};
    spheres.insert(spheres.end(), cover.begin(), cover.end());
    const bool is_at_link = pose.matrix() == Eigen::Matrix4d::Identity();
    parts.push_back({link, model, pose, is_at_link, own, {touching.begin(), touching.end()}});
}

void Robot::Impl::add_group(std::uint32_t first)
{
    Group group{first, static_cast<std::uint32_t>(parts.size()), parts[first].link, parts[first].cover.whole};
    if (group.end - first > 1) {
        std::vector<CoverSphere> wholes;
        for (std::uint32_t i = first; i < group.end; ++i) wholes.push_back(parts[i].cover.whole);
        group.whole = around_spheres(wholes);
    }
    groups.push_back(group);
}

void Robot::Impl::take_in_groups()
{
    covers.clear(), idle = no_checkers(), idle_finders = no_finders(), cells.reset();
    for (const Group& group : groups) {
        std::vector<CoverSphere> balls;
        std::vector<std::uint32_t> of;
        for (std::uint32_t i = group.first; i < group.end; ++i) {
            const auto first = spheres.begin() + parts[i].cover.first;
            balls.insert(balls.end(), first, first + parts[i].cover.count);
            of.resize(balls.size(), i);
        }
        covers.emplace_back(balls, of, group.whole, group.link);
    }
    find_pairs();
    find_sound_poses();
}

void Robot::Impl::check_world(const World& world) const
{
    if (!world.models().contains(any_model)) fail("the World is not the one that the robot was made for");
}

void Robot::Impl::check_pose(const std::string& of, const Eigen::Isometry3d& pose) const
{
    if (const std::string why = why_not_rigid(pose); !why.empty())
        refuse(fmt::format("robot '{}': {}", printable(description.name), printable(of)), why);
}

void Robot::Impl::find_sound_poses()
{
    double skew = 0, size = 0;
    const auto add = [&](const Eigen::Isometry3d& pose) {
        const Eigen::Matrix3d r = pose.linear();
        skew += (r.transpose() * r - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
        size += pose.translation().cwiseAbs().sum();
    };
    add(base);
    for (const RobotJoint& joint : description.joints) {
        add(joint.origin);
        size += (most_joint_number * std::abs(joint.multiplier) + std::abs(joint.offset)) * 3;
    }
    for (const Part& part : parts) add(part.pose);
    has_sound_poses = skew <= 0.9e-6 && size <= 1e14;
}

void Robot::Impl::check_poses(const Eigen::Isometry3d* links, std::size_t configuration) const
{
    for (const Part& part : parts) {
        if (const std::string why = WorldAccess::why_refused(pose_of(part, links)); !why.empty())
            refuse(fmt::format("robot '{}': configuration {}: link '{}'", printable(description.name), configuration,
                               printable(description.links[part.link].name)),
                   why);
    }
}

std::vector<std::uint32_t> Robot::Impl::own_slots(const World& world) const
{
    std::vector<std::uint32_t> slots;
    for (const BodyId body : bodies)
        if (world.bodies().contains(body)) slots.push_back(body.slot);
    std::ranges::sort(slots);
    return slots;
}

void Robot::Impl::check_width(std::size_t numbers) const
{
    if (numbers != tree.width())
        fail(fmt::format("a configuration of {} numbers; '{}' has {}", numbers, printable(description.name),
                         tree.width()));
}

void Robot::Impl::check_numbers(const char* call, const char* item, const Robot& robot, std::span<const double> numbers,
                                std::size_t count)
{
    const std::size_t width = robot.width();
    if (numbers.size() != count * width)
        fail(fmt::format("{}: {} numbers for {} {}s of {}", call, numbers.size(), count, item, width));
    const auto is_plain = [](const RobotJoint& joint) { return joint.kind != JointKind::floating; };
    if (std::ranges::all_of(robot.description().joints, is_plain) &&
        std::ranges::all_of(numbers, [](double number) { return std::abs(number) <= most_joint_number; }))
        return;
    for (std::size_t i = 0; i < count; ++i) try {
            robot.check_configuration(numbers.subspan(i * width, width), false);
        } catch (const Error& error) {
            throw Error(error.kind(), fmt::format("{} {}: {}", item, i, error.what()));
        }
}

Robot::Robot(World& world, RobotDescription description, const Eigen::Isometry3d& base)
    : impl_(std::make_unique<Impl>(world, std::move(description), base))
{
}
Robot::~Robot() = default;
Robot::Robot(Robot&&) noexcept = default;
Robot& Robot::operator=(Robot&&) noexcept = default;

const RobotDescription& Robot::description() const
{
    return impl_->description;
}
std::size_t Robot::width() const
{
    return impl_->tree.width();
}
const std::vector<std::string>& Robot::names() const
{
    return impl_->tree.names();
}
void Robot::set_base(const Eigen::Isometry3d& base)
{
    impl_->check_pose("base", base);
    impl_->base = base;
    impl_->find_sound_poses();
}

std::vector<double> Robot::neutral() const
{
    return impl_->neutral;
}

void Robot::apply_state(std::string_view name, std::string_view group, std::span<double> configuration) const
{
    impl_->check_width(configuration.size());
    const RobotState* found = nullptr;
    std::vector<std::string_view> names;
    for (const RobotState& state : description().states) {
        names.push_back(state.name);
        if (state.name != name || (!group.empty() && state.group != group)) continue;
        if (found)
            fail(fmt::format("two groups have a state '{}': '{}' and '{}'", printable(name), printable(found->group),
                             printable(state.group)));
        found = &state;
    }
    if (!found) fail(fmt::format("no state '{}'{}", printable(name), printable(valid_names(name, names))));
    for (const RobotState::Value& value : found->values)
        std::ranges::copy(value.numbers, configuration.begin() + impl_->tree.first_number(value.joint));
}

void Robot::check_configuration(std::span<const double> configuration, bool limits) const
{
    impl_->check_width(configuration.size());
    for (std::uint32_t i = 0; i < description().joints.size(); ++i) {
        const RobotJoint& joint = description().joints[i];
        const int count = numbers_of(joint);
        if (count == 0) continue;
        const double* const numbers = configuration.data() + impl_->tree.first_number(i);
        const auto bad = [&](const std::string& what) {
            refuse(fmt::format("robot '{}': joint '{}'", printable(description().name), printable(joint.name)), what);
        };
        for (int n = 0; n < count; ++n)
            if (!(std::abs(numbers[n]) <= most_joint_number))
                bad(fmt::format("{} is not a number up to 1e9", numbers[n]));
        if (count == 7 && !(std::abs(Eigen::Map<const Eigen::Vector4d>(numbers + 3).norm() - 1) <= 1e-6))
            bad("its quaternion is not of length 1");
        if (limits && count == 1 && !(numbers[0] >= joint.lower && numbers[0] <= joint.upper))
            bad(fmt::format("{} is out of its limits, {} to {}", numbers[0], joint.lower, joint.upper));
    }
}

void Robot::link_poses(std::span<const double> configuration, std::span<Eigen::Isometry3d> poses) const
{
    check_configuration(configuration, false);
    if (poses.size() != description().links.size())
        fail(fmt::format("room for {} poses; the robot has {} links", poses.size(), description().links.size()));
    impl_->tree.link_poses(configuration.data(), impl_->base, poses.data());
}

void Robot::jacobian(std::span<const double> configuration, std::uint32_t link, const Eigen::Vector3d& point,
                     std::span<double> rows) const
{
    const Impl& p = *impl_;
    check_configuration(configuration, false);
    const std::size_t links = description().links.size();
    p.check_link("jacobian", link);
    if (rows.size() != 6 * width())
        fail(fmt::format("jacobian: room for {} numbers; 6 rows of {} are {}", rows.size(), width(), 6 * width()));
    std::vector<Eigen::Isometry3d> poses(links, Eigen::Isometry3d::Identity());
    p.tree.link_poses(configuration.data(), p.base, poses.data());
    const Eigen::Vector3d at = poses[link] * point;
    std::ranges::fill(rows, 0.0);
    p.tree.each_twist(configuration.data(), poses.data(), link, [&](std::uint32_t k, const Kinematics::Twist& t) {
        const Eigen::Vector3d moved = t.linear + t.angular.cross(at - t.origin);
        for (std::size_t row = 0; row < 3; ++row) {
            const auto axis = static_cast<Eigen::Index>(row);
            rows[row * width() + k] += moved[axis], rows[(3 + row) * width() + k] += t.angular[axis];
        }
    });
}

} // namespace oncollide
