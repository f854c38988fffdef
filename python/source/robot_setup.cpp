// Robot: the base, attached objects, padding, allowed contacts, and bodies.
#include "held_robot.hpp"

namespace oncollide::python {

namespace {

std::uint32_t attach(HeldRobot& robot, py::handle link, py::handle model, py::handle at, py::handle touching)
{
    const char* const call = "Robot.attach";
    std::vector<std::uint32_t> links;
    for (const py::handle each : touching) links.push_back(link_of(robot, each, {call, "touching"}));
    const std::uint32_t to = link_of(robot, link, {call, "link"});
    const ModelId id = model_of(model, {call, "model"});
    const Eigen::Isometry3d place = pose(at, {call, "pose"});
    const Inside inside(*robot.held, call);
    return robot.robot->attach(robot.held->world, to, id, place, links);
}

/// Numbers of {key: number}.
template <class Each>
void each_number(py::handle numbers, const Place& place, Each each)
{
    if (numbers.is_none()) return;
    if (!py::isinstance<py::dict>(numbers)) refuse_type(place, "a dict of lengths", numbers);
    for (const auto& [key, value] : py::reinterpret_borrow<py::dict>(numbers)) each(key, number(value, place));
}

std::pair<py::object, py::object> two_of(py::handle value, const Place& place)
{
    if (!py::isinstance<py::tuple>(value) || py::len(value) != 2) refuse_type(place, "a tuple of two", value);
    const auto both = py::reinterpret_borrow<py::tuple>(value);
    return {both[0], both[1]};
}

void set_padding(HeldRobot& robot, py::handle environment, py::handle self, py::handle links, py::handle bodies,
                 py::handle pairs)
{
    const char* const call = "Robot.set_padding";
    const Place of_links{call, "links"}, of_bodies{call, "bodies"}, of_pairs{call, "pairs"};
    RobotPadding padding{.environment = number(environment, {call, "environment"}),
                         .self = number(self, {call, "self_collision"})};
    each_number(links, of_links, [&](py::handle link, double clearance) {
        padding.links.push_back({link_of(robot, link, of_links), clearance});
    });
    each_number(bodies, of_bodies, [&](py::handle key, double clearance) {
        if (!py::isinstance<py::tuple>(key)) {
            padding.bodies.push_back({body(key, of_bodies), clearance});
            return;
        }
        const auto [link, other] = two_of(key, of_bodies);
        padding.bodies.push_back({body(other, of_bodies), clearance, link_of(robot, link, of_bodies)});
    });
    each_number(pairs, of_pairs, [&](py::handle key, double clearance) {
        const auto [a, b] = two_of(key, of_pairs);
        padding.pairs.push_back({link_of(robot, a, of_pairs), link_of(robot, b, of_pairs), clearance});
    });
    const Inside inside(*robot.held, call);
    robot.robot->set_padding(padding);
}

void set_allowed(HeldRobot& robot, py::handle links, py::handle bodies)
{
    const char* const call = "Robot.set_allowed";
    const Place of_links{call, "links"}, of_bodies{call, "bodies"};
    std::vector<AllowedContact> allowed;
    for (const py::handle each : links) {
        const auto [a, b] = two_of(each, of_links);
        allowed.push_back({.link = link_of(robot, a, of_links), .other = link_of(robot, b, of_links)});
    }
    for (const py::handle each : bodies) {
        const auto [link, other] = two_of(each, of_bodies);
        allowed.push_back({.link = link_of(robot, link, of_bodies), .body = body(other, of_bodies)});
    }
    const Inside inside(*robot.held, call);
    robot.robot->set_allowed(allowed);
}

py::array add_bodies(HeldRobot& robot, py::handle layer, py::handle mask, py::handle group)
{
    const char* const call = "Robot.add_bodies";
    const CollisionFilter filter = filter_of(layer, mask, group, call);
    const Inside inside(*robot.held, call);
    robot.robot->add_bodies(robot.held->world, {.layer = filter.layer, .mask = filter.mask, .group = filter.group});
    return ids_of(robot.robot->bodies());
}

void set_joints(HeldRobot& robot, py::handle configuration)
{
    const char* const call = "Robot.set_joints";
    const py::array row = rows_of(robot, configuration, {call, "configuration"});
    if (row.ndim() != 1) refuse_value({call, "configuration"}, "one configuration, not many");
    const Inside inside(*robot.held, call);
    robot.robot->set_joints(robot.held->world, span_of(row));
}

} // namespace

void bind_robot_setup(py::class_<HeldRobot>& robot)
{
    using namespace py::literals;
    define(
        robot, "set_base",
        [](HeldRobot& held, py::handle at) {
            const Eigen::Isometry3d to = pose(at, {"Robot.set_base", "pose"});
            const Inside inside(*held.held, "Robot.set_base");
            held.robot->set_base(to);
        },
        "Moves the root link.", "pose"_a);
    define(
        robot, "attach", &attach,
        "Fixes a model of the World to a link (name or index), as an object in a gripper, and returns its number. Its "
        "pairs with this link and with the links in `touching` are not tested. Remove the robot's bodies first.",
        "link"_a, "model"_a, "pose"_a = py::none(), "touching"_a = py::tuple());
    define(
        robot, "detach_all",
        [](HeldRobot& held) {
            const Inside inside(*held.held, "Robot.detach_all");
            held.robot->detach_all();
        },
        "Removes all attached objects; their models stay.");
    define(robot, "set_padding", &set_padding,
           R"(Replaces the clearances of check() and check_edges(), in metres: pairs that are closer are WITHIN.

environment: of links and bodies; self_collision: of two links. Instead of these: links, a dict by link (name or index),
for all bodies; bodies, a dict by body id or (link, body id); pairs, a dict by (link, link). A configuration is tested
until a pair collides or is within its clearance. Raises Error for a negative clearance.)",
           "environment"_a = 0.0, "self_collision"_a = 0.0, "links"_a = py::none(), "bodies"_a = py::none(),
           "pairs"_a = py::none());
    define(robot, "set_allowed", &set_allowed,
           "Replaces the contacts that are allowed: pairs that are not tested. links: tuples of two links (names or "
           "indices); bodies: tuples (link, body id). Remove the robot's bodies first.",
           "links"_a = py::tuple(), "bodies"_a = py::tuple());
    const SharedArguments with;
    define(
        robot, "add_bodies", &add_bodies,
        "Adds a body for each geometry of the links and for each attached object, at neutral(), and returns their ids, "
        "uint64 (N,). Pairs that are not tested are excluded.",
        with.layer, with.mask, with.group);
    define(robot, "set_joints", &set_joints, "Moves the robot's bodies to a configuration, float64 (width,).",
           "configuration"_a);
    define(
        robot, "remove_bodies",
        [](HeldRobot& held) {
            const Inside inside(*held.held, "Robot.remove_bodies");
            held.robot->remove_bodies(held.held->world);
        },
        "Removes the robot's bodies.");
    robot.def_property_readonly(
        "bodies", [](const HeldRobot& held) { return ids_of(held.robot->bodies()); },
        "The ids of the robot's bodies, uint64 (N,): links in order, then attached objects. Empty: it has none.");
}

} // namespace oncollide::python
