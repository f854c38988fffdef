#include <oncollide/robots/description_fault.hpp>

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include <fmt/format.h>

#include <oncollide/base/rigid.hpp>
#include <oncollide/scenes/files/mesh/mesh_source.hpp> // quoted()

namespace oncollide {

namespace {

using Of = DescriptionFault::Of;

constexpr std::uint32_t none = 0xffffffffu;

bool has_one_number(JointKind kind)
{
    return kind == JointKind::revolute || kind == JointKind::continuous || kind == JointKind::prismatic;
}

std::string no_such(const char* kind, std::int64_t number, std::size_t count)
{
    return fmt::format("{} {} does not exist; the robot has {} {}s", kind, number, count, kind);
}

// Each why_not_...() returns why the item is refused; empty: it is accepted.

std::string why_not_geometry(const LinkGeometry& collision)
{
    if (!collision.geometry) return "there is no geometry";
    if (std::string why = why_not_rigid(collision.pose); !why.empty()) return why;
    try {
        check_geometry("geometry", collision.geometry->data);
    } catch (const Error& error) {
        return error.what();
    }
    return {};
}

std::string why_not_link(const RobotLink& link)
{
    for (std::size_t i = 0; i < link.collision.size(); ++i)
        if (std::string why = why_not_geometry(link.collision[i]); !why.empty())
            return link.collision.size() == 1 ? why : fmt::format("collision {}: {}", i, why);
    return {};
}

std::string why_not_mimic(const RobotDescription& robot, const RobotJoint& joint)
{
    if (joint.mimics < 0 || static_cast<std::size_t>(joint.mimics) >= robot.joints.size())
        return "mimics joint " + no_such("joint", joint.mimics, robot.joints.size()).substr(6);
    const RobotJoint& of = robot.joints[static_cast<std::size_t>(joint.mimics)];
    if (!has_one_number(joint.kind) || !has_one_number(of.kind))
        return "only revolute, continuous and prismatic joints can mimic each other";
    if (&of == &joint) return "mimics itself";
    if (of.mimics != -1)
        return fmt::format("mimics joint {}, which has no value of its own", oncollide::quoted(of.name));
    for (const auto& [name, value] : {std::pair("multiplier", joint.multiplier), {"offset", joint.offset}})
        if (!(std::abs(value) <= most_joint_number))
            return fmt::format("its {} is {}; must be a number up to 1e9", name, value);
    return {};
}

std::string why_not_joint(const RobotDescription& robot, const RobotJoint& joint)
{
    if (joint.kind > JointKind::floating) return fmt::format("there is no kind {} of joints", int(joint.kind));
    for (const std::uint32_t link : {joint.parent, joint.child})
        if (link >= robot.links.size()) return no_such("link", link, robot.links.size());
    if (joint.parent == joint.child) return "connects a link with itself";
    if (std::string why = why_not_rigid(joint.origin); !why.empty()) return why;
    const bool has_axis = has_one_number(joint.kind) || joint.kind == JointKind::planar;
    if (has_axis && !(std::abs(joint.axis.norm() - 1) <= 1e-6))
        return fmt::format("its axis ({}, {}, {}) is not of length 1", joint.axis.x(), joint.axis.y(), joint.axis.z());
    if (!(joint.lower <= joint.upper)) return fmt::format("its limits are {} to {}", joint.lower, joint.upper);
    if (joint.lower > most_joint_number || joint.upper < -most_joint_number)
        return fmt::format("its limits, {} to {}, exclude everything up to 1e9", joint.lower, joint.upper);
    return joint.mimics == -1 ? std::string() : why_not_mimic(robot, joint);
}

std::string why_not_excluded(const RobotDescription& robot, const std::pair<std::uint32_t, std::uint32_t>& pair)
{
    for (const std::uint32_t link : {pair.first, pair.second})
        if (link >= robot.links.size()) return no_such("link", link, robot.links.size());
    return pair.first != pair.second
               ? std::string()
               : fmt::format("names link {} twice", oncollide::quoted(robot.links[pair.first].name));
}

std::string why_not_group(const RobotDescription& robot, const RobotGroup& group)
{
    for (const std::uint32_t link : group.links)
        if (link >= robot.links.size()) return no_such("link", link, robot.links.size());
    for (const std::uint32_t joint : group.joints)
        if (joint >= robot.joints.size()) return no_such("joint", joint, robot.joints.size());
    return {};
}

std::string why_not_state(const RobotDescription& robot, const RobotState& state)
{
    if (!state.group.empty() && !std::ranges::count(robot.groups, state.group, &RobotGroup::name))
        return fmt::format("there is no group {}", oncollide::quoted(state.group));
    for (const RobotState::Value& value : state.values) {
        if (value.joint >= robot.joints.size()) return no_such("joint", value.joint, robot.joints.size());
        const RobotJoint& joint = robot.joints[value.joint];
        if (const auto own = static_cast<std::size_t>(numbers_of(joint)); value.numbers.size() != own)
            return fmt::format("joint {} takes {} numbers, not {}", oncollide::quoted(joint.name), own,
                               value.numbers.size());
        for (const double number : value.numbers)
            if (!(std::abs(number) <= most_joint_number))
                return fmt::format("joint {}: {} is not a number up to 1e9", oncollide::quoted(joint.name), number);
    }
    return {};
}

/// The first item that why(item) refuses.
template <class Item, class Why>
std::optional<DescriptionFault> first_of(Of of, const std::vector<Item>& items, Why why)
{
    for (std::uint32_t i = 0; i < items.size(); ++i)
        if (std::string what = why(items[i]); !what.empty()) return DescriptionFault{of, i, std::move(what)};
    return {};
}

/// The first item without a name, or with the name of another one.
template <class Item>
std::optional<DescriptionFault> fault_of_names(Of of, const char* kind, const std::vector<Item>& items)
{
    std::unordered_set<std::string_view> names;
    return first_of(of, items, [&](const Item& item) -> std::string {
        if (item.name.empty()) return "has no name";
        if (!names.insert(item.name).second) return fmt::format("there are two {}s of this name", kind);
        return {};
    });
}

/// One link is the root. Each other link must be the child of one joint, and below the root.
std::optional<DescriptionFault> fault_of_tree(const RobotDescription& robot)
{
    std::vector<std::uint32_t> above(robot.links.size(), none); // by link: the joint that leads to it
    const auto name_of_link = [&](std::size_t i) { return oncollide::quoted(robot.links[i].name); };
    for (std::uint32_t i = 0; i < robot.joints.size(); ++i) {
        std::uint32_t& mine = above[robot.joints[i].child];
        if (mine != none)
            return DescriptionFault{Of::joint, i,
                                    fmt::format("link {} is already the child of joint {}; a robot is a tree",
                                                name_of_link(robot.joints[i].child),
                                                oncollide::quoted(robot.joints[mine].name))};
        mine = i;
    }
    std::uint32_t root = none;
    for (std::uint32_t i = 0; i < above.size(); ++i) {
        if (above[i] != none) continue;
        if (root != none)
            return DescriptionFault{
                Of::link, i, fmt::format("is a second root, beside {}: no joint leads to it", name_of_link(root))};
        root = i;
    }
    // The link from which the walk up reached this one.
    std::vector<std::uint32_t> reached_from(robot.links.size(), none);
    for (std::uint32_t i = 0; i < above.size(); ++i)
        for (std::uint32_t at = i; reached_from[at] == none || reached_from[at] == i;
             at = robot.joints[above[at]].parent) {
            if (reached_from[at] == i)
                return DescriptionFault{Of::link, i, "the joints above it form a loop; a robot is a tree"};
            reached_from[at] = i;
            if (at == root) break;
        }
    return {};
}

} // namespace

int numbers_of(const RobotJoint& joint)
{
    if (joint.mimics >= 0 || joint.kind == JointKind::fixed) return 0;
    return joint.kind == JointKind::planar ? 3 : joint.kind == JointKind::floating ? 7 : 1;
}

std::optional<DescriptionFault> fault_of(const RobotDescription& robot)
{
    constexpr std::size_t most = 0x7fffffff; // RobotJoint::mimics counts so far
    if (robot.links.empty()) return DescriptionFault{Of::robot, 0, "has no link"};
    if (robot.links.size() > most || robot.joints.size() > most)
        return DescriptionFault{Of::robot, 0, fmt::format("has more than {} links or joints", most)};
    const auto with_robot = [&](auto why) { return [&robot, why](const auto& item) { return why(robot, item); }; };
    std::optional<DescriptionFault> fault = fault_of_names(Of::link, "link", robot.links);
    if (!fault) fault = fault_of_names(Of::joint, "joint", robot.joints);
    if (!fault) fault = first_of(Of::link, robot.links, why_not_link);
    if (!fault) fault = first_of(Of::joint, robot.joints, with_robot(why_not_joint));
    if (!fault) fault = fault_of_tree(robot);
    if (!fault) fault = first_of(Of::excluded, robot.excluded, with_robot(why_not_excluded));
    if (!fault) fault = fault_of_names(Of::group, "group", robot.groups);
    if (!fault) fault = first_of(Of::group, robot.groups, with_robot(why_not_group));
    if (!fault) fault = first_of(Of::state, robot.states, with_robot(why_not_state));
    return fault;
}

void check_description(const RobotDescription& robot)
{
    const std::optional<DescriptionFault> fault = fault_of(robot);
    if (!fault) return;
    const auto named = [&](const char* kind, const auto& items) {
        const std::string& name = items[fault->number].name;
        return fmt::format(": {} {}", kind, name.empty() ? std::to_string(fault->number) : oncollide::quoted(name));
    };
    std::string part;
    if (fault->of == Of::link) part = named("link", robot.links);
    if (fault->of == Of::joint) part = named("joint", robot.joints);
    if (fault->of == Of::group) part = named("group", robot.groups);
    if (fault->of == Of::state) part = named("state", robot.states);
    if (fault->of == Of::excluded) part = fmt::format(": excluded pair {}", fault->number);
    refuse(fmt::format("robot {}{}", oncollide::quoted(robot.name), part), fault->what);
}

} // namespace oncollide
