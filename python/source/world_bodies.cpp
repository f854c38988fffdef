// The bodies of a World.
#include <fmt/format.h>

#include "held_world.hpp"

namespace oncollide::python {

namespace {

void check_length(const Poses& poses, std::size_t count, const Place& place)
{
    if (!poses.one() && poses.size() != count)
        refuse_value(place,
                     fmt::format("{} poses for {} bodies; must be as many, or one for all", poses.size(), count));
}

/// The keyword `static`, or its older name `fixed` if given.
bool static_or_fixed(py::handle is_static, py::handle fixed, const char* call)
{
    return fixed.is_none() ? truth(is_static, {call, "static"}) : truth(fixed, {call, "fixed"});
}

py::object add_body(HeldWorld& held, py::handle model, py::handle at, py::handle is_static, py::handle layer,
                    py::handle mask, py::handle group, py::handle user, py::handle fixed)
{
    const char* const call = "World.add_body";
    const BodySpec spec{.model = model_of(held, model, {call, "model"}),
                        .pose = pose(at, {call, "pose"}),
                        .is_static = static_or_fixed(is_static, fixed, call),
                        .layer = bits(layer, {call, "layer"}),
                        .mask = bits(mask, {call, "mask"}),
                        .group = bits(group, {call, "group"}),
                        .user = whole(user, {call, "user"}, ~0ull)};
    const Inside inside(held, call);
    return py::int_(number_of(held.world.bodies().add(spec)));
}

py::array add_bodies(HeldWorld& held, py::handle model, py::handle at, py::handle is_static, py::handle layer,
                     py::handle mask, py::handle group, py::handle fixed)
{
    const char* const call = "World.add_bodies";
    const BodySpec spec{.model = model_of(held, model, {call, "model"}),
                        .is_static = static_or_fixed(is_static, fixed, call),
                        .layer = bits(layer, {call, "layer"}),
                        .mask = bits(mask, {call, "mask"}),
                        .group = bits(group, {call, "group"})};
    const Poses poses(at, {call, "poses"});
    std::vector<BodySpec> specs(poses.size(), spec);
    for (std::size_t i = 0; i < specs.size(); ++i) specs[i].pose = poses[i];
    std::vector<BodyId> ids(specs.size());
    const Inside inside(held, call);
    held.world.bodies().add(specs, ids);
    return ids_of(ids);
}

void set_poses(HeldWorld& held, py::handle which, py::handle at)
{
    const char* const call = "World.set_poses";
    const std::vector<BodyId> ids = bodies(which, {call, "bodies"});
    const Poses poses(at, {call, "poses"});
    check_length(poses, ids.size(), {call, "poses"});
    std::vector<Eigen::Isometry3d> made(ids.size());
    for (std::size_t i = 0; i < ids.size(); ++i) made[i] = poses[i];
    const Inside inside(held, call);
    held.world.bodies().set_pose(ids, made);
}

void set_motions(HeldWorld& held, py::handle which, py::handle at, py::handle path)
{
    const char* const call = "World.set_motions";
    const std::vector<BodyId> ids = bodies(which, {call, "bodies"});
    const Poses poses(at, {call, "poses"});
    check_length(poses, ids.size(), {call, "poses"});
    const MotionPath along = motion_path(path, {call, "path"});
    std::vector<Eigen::Isometry3d> made(ids.size());
    for (std::size_t i = 0; i < ids.size(); ++i) made[i] = poses[i];
    const Inside inside(held, call);
    held.world.bodies().set_motion(ids, made, along);
}

void set_motion(HeldWorld& held, py::handle which, py::handle at, py::handle times, py::handle path)
{
    const char* const call = "World.set_motion";
    const BodyId id = body(which, {call, "body"});
    const Poses poses(at, {call, "poses"});
    const std::size_t count = poses.size();
    if (count < 2) refuse_value({call, "poses"}, "expected at least two poses, got " + std::to_string(count));
    const py::array when = times.is_none() ? py::array() : doubles(times, {call, "times"});
    if (!times.is_none() && !has_shape(when, {static_cast<py::ssize_t>(count)}))
        refuse_value({call, "times"}, "expected one per pose, " + std::to_string(count) + ", got " + shape_of(when));
    const auto* const given = static_cast<const double*>(when.data());
    std::vector<RigidMotion::Key> keys;
    for (std::size_t i = 0; i < count; ++i)
        keys.push_back({times.is_none() ? double(i) / double(count - 1) : given[i], poses[i]});
    const RigidMotion motion(keys, motion_path(path, {call, "path"}));
    const Inside inside(held, call);
    held.world.bodies().set_motion(id, motion);
}

py::array pose_of(HeldWorld& held, py::handle which)
{
    const BodyId id = body(which, {"World.pose", "body"});
    const Looking looking(held, "World.pose");
    py::array_t<double> made({4, 4});
    Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(made.mutable_data()) =
        held.world.bodies().pose(id).matrix();
    return made;
}

/// A method that changes one body.
template <class Change>
void change(HeldWorld& held, const char* call, py::handle which, Change work)
{
    const BodyId id = body(which, {call, "body"});
    const Inside inside(held, call);
    work(id);
}

} // namespace

void bind_bodies(WorldClass& world)
{
    using namespace py::literals;
    const auto none = py::none();
    const py::int_ all(0xffffffffu);
    world.def("add_body", &add_body, "model"_a, "pose"_a = none, "static"_a = false, "layer"_a = 1, "mask"_a = all,
              "group"_a = 0, "user"_a = 0, "fixed"_a = none,
              R"(add_body(self, model, pose=None, static=False, layer=1, mask=4294967295, group=0, user=0, fixed=None)
--

Adds a body and returns its id (int).

pose: (4, 4) or (7,), metres; None: the identity. static: two static bodies never form a pair;
fixed: its older name. layer, mask: bits; a pair
is tested if the layer of each has a bit in common with the mask of the other. group: bodies of one group other than 0
never collide; to keep only neighbours apart, as the links of a robot, use exclude().
user: any number up to 2^64 - 1, which World.bodies().user() returns.)");
    world.def("add_bodies", &add_bodies, "model"_a, "poses"_a, "static"_a = false, "layer"_a = 1, "mask"_a = all,
              "group"_a = 0, "fixed"_a = none,
              R"(add_bodies(self, model, poses, static=False, layer=1, mask=4294967295, group=0, fixed=None)
--

Adds a body for each of the poses, (N, 4, 4) or (N, 7), and returns their ids, uint64 (N,).)");
    world.def(
        "remove_body",
        [](HeldWorld& held, py::handle which) {
            change(held, "World.remove_body", which, [&](BodyId id) { held.world.bodies().remove(id); });
        },
        "body"_a, R"(remove_body(self, body)
--

Removes a body; its id is stale from now on.)");
    world.def(
        "remove_bodies",
        [](HeldWorld& held, py::handle which) {
            const std::vector<BodyId> ids = bodies(which, {"World.remove_bodies", "bodies"});
            const Inside inside(held, "World.remove_bodies");
            held.world.bodies().remove(ids);
        },
        "bodies"_a, R"(remove_bodies(self, bodies)
--

Removes bodies, each once. bodies: (N,) ids.)");

    world.def(
        "set_pose",
        [](HeldWorld& held, py::handle which, py::handle at) {
            const Eigen::Isometry3d to = pose(at, {"World.set_pose", "pose"});
            change(held, "World.set_pose", which, [&](BodyId id) { held.world.bodies().set_pose(id, to); });
        },
        "body"_a, "pose"_a, R"(set_pose(self, body, pose)
--

Moves a body. pose: (4, 4) or (7,), metres; rigid to 1e-6.)");
    world.def("set_poses", &set_poses, "bodies"_a, "poses"_a, R"(set_poses(self, bodies, poses)
--

Moves many. bodies: (N,) ids. poses: (N, 4, 4) or (N, 7), metres, or one pose for all. If one is invalid, none moves.)");
    world.def("set_motions", &set_motions, "bodies"_a, "poses"_a, "path"_a = "linear",
              R"(set_motions(self, bodies, poses, path="linear")
--

Moves many as set_poses() does, and lets the next step() report contacts on the way, in Frame.sweeps: from their poses
so far to `poses`, over the time from 0 to 1. path: "linear" or "screw".)");
    world.def("set_motion", &set_motion, "body"_a, "poses"_a, "times"_a = none, "path"_a = "linear",
              R"(set_motion(self, body, poses, times=None, path="linear")
--

Moves a body to the last of `poses`, and lets the next step() report contacts on the way through all of them. poses:
(N, 4, 4) or (N, 7), at least two. times: float64 (N,), ascending from 0 to 1; None: evenly spaced. path: from each pose
to the next, as in set_motions().)");
    world.def(
        "set_static",
        [](HeldWorld& held, py::handle which, py::handle is_static) {
            const bool now = truth(is_static, {"World.set_static", "static"});
            change(held, "World.set_static", which, [&](BodyId id) { held.world.bodies().set_static(id, now); });
        },
        "body"_a, "static"_a, R"(set_static(self, body, static)
--

Makes a body static or dynamic. Two static bodies never form a pair; a static body may still be moved.)");
    world.attr("set_fixed") = world.attr("set_static"); // its older name
    const auto many = [&](const char* name, const char* call, void (World::*method)(std::span<const BodyId>),
                          const char* text) {
        world.def(
            name,
            [call, method](HeldWorld& held, py::handle which) {
                const std::vector<BodyId> ids = bodies(which, {call, "bodies"});
                const Inside inside(held, call);
                (held.world.*method)(ids);
            },
            "bodies"_a, text);
    };
    many("sleep", "World.sleep", &World::sleep, R"(sleep(self, bodies)
--

Puts bodies to sleep: a pair of two bodies that are each asleep or static keeps its result untested. A change of its pose,
filter or model wakes a body. bodies: (N,) ids.)");
    many("wake", "World.wake", &World::wake, R"(wake(self, bodies)
--

Undoes sleep(). bodies: (N,) ids.)");
    world.def(
        "set_layers",
        [](HeldWorld& held, py::handle which, py::handle layer, py::handle mask) {
            const char* const call = "World.set_layers";
            const std::uint32_t on = bits(layer, {call, "layer"}), with = bits(mask, {call, "mask"});
            change(held, call, which, [&](BodyId id) { held.world.set_layers(id, on, with); });
        },
        "body"_a, "layer"_a, "mask"_a, R"(set_layers(self, body, layer, mask)
--

Sets the layers that a body is on, and the layers that it collides with: bits.)");
    world.def(
        "set_group",
        [](HeldWorld& held, py::handle which, py::handle group) {
            const std::uint32_t of = bits(group, {"World.set_group", "group"});
            change(held, "World.set_group", which, [&](BodyId id) { held.world.set_group(id, of); });
        },
        "body"_a, "group"_a, R"(set_group(self, body, group)
--

Sets a body's group. Bodies of one group other than 0 never collide; exclude() keeps one pair apart.)");
    world.def(
        "set_model",
        [](HeldWorld& held, py::handle which, py::handle model) {
            const ModelId id = model_of(held, model, {"World.set_model", "model"});
            change(held, "World.set_model", which, [&](BodyId body) { held.world.bodies().set_model(body, id); });
        },
        "body"_a, "model"_a, R"(set_model(self, body, model)
--

Gives a body another model.)");
    world.def(
        "set_user",
        [](HeldWorld& held, py::handle which, py::handle user) {
            const std::uint64_t now = whole(user, {"World.set_user", "user"}, ~0ull);
            change(held, "World.set_user", which, [&](BodyId id) { held.world.bodies().set_user(id, now); });
        },
        "body"_a, "user"_a, R"(set_user(self, body, user)
--

Stores any number up to 2^64 - 1 with a body.)");
    const auto two = [&](const char* name, const char* call, auto method, const char* text) {
        world.def(
            name,
            [call, method](HeldWorld& held, py::handle a, py::handle b) {
                const BodyId first = body(a, {call, "a"}), second = body(b, {call, "b"});
                const Inside inside(held, call);
                (held.world.*method)(first, second);
            },
            "a"_a, "b"_a, text);
    };
    two("exclude", "World.exclude", &World::exclude, R"(exclude(self, a, b)
--

These two bodies never form a pair, until include() or until one is removed.)");
    two("include", "World.include", &World::include, R"(include(self, a, b)
--

Undoes exclude().)");

    world.def("pose", &pose_of, "body"_a, R"(pose(self, body)
--

The pose of a body: float64 (4, 4), a copy.)");
    world.def(
        "model",
        [](HeldWorld& held, py::handle which) {
            const BodyId id = body(which, {"World.model", "body"});
            const Looking looking(held, "World.model");
            return ModelHandle{held.number, held.world.bodies().model(id)};
        },
        "body"_a, R"(model(self, body)
--

The Model of a body.)");
    const auto property = [&](const char* name, const char* call, auto get, const char* text) {
        world.def(
            name,
            [call, get](HeldWorld& held, py::handle which) {
                const BodyId id = body(which, {call, "body"});
                const Looking looking(held, call);
                return (held.world.*get)(id);
            },
            "body"_a, text);
    };
    property("user", "World.user", &World::user, R"(user(self, body)
--

The number stored by set_user() (int).)");
    property("is_static", "World.is_static", &World::is_static, R"(is_static(self, body)
--

True if the body is static.)");
    world.attr("fixed") = world.attr("is_static"); // its older name
    property("is_asleep", "World.is_asleep", &World::is_asleep, R"(is_asleep(self, body)
--

True if the body is asleep.)");
    world.def(
        "body_at",
        [](HeldWorld& held, py::handle slot) -> py::object {
            const auto at = static_cast<std::uint32_t>(whole(slot, {"World.body_at", "slot"}, 0xffffffffu));
            const Looking looking(held, "World.body_at");
            const BodyId id = held.world.bodies().at(at);
            return id ? py::object(py::int_(number_of(id))) : py::none();
        },
        "slot"_a, R"(body_at(self, slot)
--

The id of the body in a slot (int), or None if the slot is free. Bodies take the slots 0, 1, 2 and so on.)");
    property("layer", "World.layer", &World::layer, R"(layer(self, body)
--

The layers that the body is on, as bits (int).)");
    property("mask", "World.mask", &World::mask, R"(mask(self, body)
--

The layers that the body collides with, as bits (int).)");
    property("group", "World.group", &World::group, R"(group(self, body)
--

The body's group (int); no two bodies of one group other than 0 form a pair.)");
    world.def(
        "excluded",
        [](HeldWorld& held, py::handle a, py::handle b) {
            const char* const call = "World.excluded";
            const BodyId first = body(a, {call, "a"}), second = body(b, {call, "b"});
            const Looking looking(held, call);
            return held.world.bodies().excluded(first, second);
        },
        "a"_a, "b"_a, R"(excluded(self, a, b)
--

True if exclude() keeps the two from forming a pair.)");
    world.def(
        "__contains__",
        [](HeldWorld& held, py::handle item) {
            const char* const call = "World.__contains__";
            if (py::isinstance<ModelHandle>(item)) {
                const auto& model = py::cast<const ModelHandle&>(item);
                const Looking looking(held, call);
                return model.world == held.number && held.world.contains(model.id);
            }
            const BodyId id = body(item, {call, "body"});
            const Looking looking(held, call);
            return held.world.contains(id);
        },
        R"(__contains__(self, item, /)
--

True if there is a body with this id, or this Model.)");
    world.def("__len__", look("World.__len__", [](const World& w) { return w.size(); }), R"(__len__(self, /)
--

Number of bodies.)");
}

} // namespace oncollide::python
