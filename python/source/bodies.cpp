// The bodies of a World.
#include <optional>

#include "held_world.hpp"

namespace oncollide::python {

namespace {

py::object add_body(BodiesView& bodies, py::handle model, py::handle at, py::handle is_static, py::handle layer,
                    py::handle mask, py::handle group, py::handle user)
{
    const char* const call = "bodies.add";
    const CollisionFilter filter = filter_of(layer, mask, group, call);
    const Poses poses(at, {call, "pose"});
    const BodySpec spec{.model = model_of(model, {call, "model"}),
                        .pose = poses.one() ? poses[0] : Eigen::Isometry3d::Identity(),
                        .is_static = truth(is_static, {call, "static"}),
                        .layer = filter.layer,
                        .mask = filter.mask,
                        .group = filter.group,
                        .user = whole(user, {call, "user"}, ~0ull)};
    Bodies& all = bodies.held->world.bodies();
    if (poses.one()) {
        const Inside inside(*bodies.held, call);
        return py::int_(number_of(all.add(spec)));
    }
    std::vector<BodySpec> specs(poses.size(), spec);
    for (std::size_t i = 0; i < specs.size(); ++i) specs[i].pose = poses[i];
    std::vector<BodyId> ids(specs.size());
    const Inside inside(*bodies.held, call);
    all.add(specs, ids);
    return ids_of(ids);
}

/// work(bodies, ids) changes bodies: one, or many.
template <class Work>
void change(BodiesView& bodies, const char* call, py::handle which, Work work)
{
    const Ids ids(which, {call, "body"});
    const Inside inside(*bodies.held, call);
    work(bodies.held->world.bodies(), std::span(ids.begin(), ids.size()));
}

/// A method that changes one body, or many.
auto changer(const char* call, void (Bodies::*method)(BodySpan))
{
    return [call, method](BodiesView& view, py::handle which) {
        change(view, call, which, [&](Bodies& all, BodySpan ids) { (all.*method)(ids); });
    };
}

/// A method that returns get() of one body, or an array of the values of many.
template <class T>
auto reader(const char* call, T (Bodies::*get)(BodyId) const)
{
    return [call, get](BodiesView& view, py::handle which) -> py::object {
        const Ids ids(which, {call, "body"});
        const Looking looking(*view.held, call);
        const Bodies& all = view.held->world.bodies();
        if (ids.one()) return py::cast((all.*get)(ids[0]));
        py::array_t<T> made(static_cast<py::ssize_t>(ids.size()));
        for (std::size_t i = 0; i < ids.size(); ++i) made.mutable_data()[i] = (all.*get)(ids[i]);
        return made;
    };
}

py::array pose_of(BodiesView& bodies, py::handle which)
{
    const char* const call = "bodies.pose";
    const Ids ids(which, {call, "body"});
    py::array_t<double> made =
        ids.one() ? py::array_t<double>({4, 4})
                  : py::array_t<double>({static_cast<py::ssize_t>(ids.size()), py::ssize_t{4}, py::ssize_t{4}});
    const Looking looking(*bodies.held, call);
    double* row = made.mutable_data();
    for (const BodyId id : ids) {
        Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> matrix(row);
        matrix = bodies.held->world.bodies().pose(id).matrix(), row += 16;
    }
    return made;
}

/// As many poses as bodies, or one for all.
std::vector<Eigen::Isometry3d> poses_of(const char* call, const Ids& ids, const Poses& poses)
{
    Lengths lengths(call);
    lengths.add("body", ids.one(), ids.size()), lengths.add("pose", poses.one(), poses.size());
    std::vector<Eigen::Isometry3d> made(ids.size());
    for (std::size_t i = 0; i < ids.size(); ++i) made[i] = poses[i];
    return made;
}

void set_pose(BodiesView& bodies, py::handle which, py::handle at)
{
    const char* const call = "bodies.set_pose";
    const Ids ids(which, {call, "body"});
    Bodies& all = bodies.held->world.bodies();
    if (ids.one()) {
        const Eigen::Isometry3d to = pose(at, {call, "pose"});
        const Inside inside(*bodies.held, call);
        return all.set_pose(ids[0], to);
    }
    const std::vector<Eigen::Isometry3d> to = poses_of(call, ids, Poses(at, {call, "pose"}));
    const Inside inside(*bodies.held, call);
    all.set_pose(ids, to);
}

void set_motion(BodiesView& bodies, py::handle which, py::handle at, py::handle times, py::handle path)
{
    const char* const call = "bodies.set_motion";
    const Ids ids(which, {call, "body"});
    const Poses poses(at, {call, "pose"});
    const MotionPath along = motion_path(path, {call, "path"});
    Bodies& all = bodies.held->world.bodies();
    if (!ids.one() || poses.one()) {
        if (!times.is_none()) refuse_value({call, "times"}, "one body that moves through many poses has times");
        const std::vector<Eigen::Isometry3d> to = poses_of(call, ids, poses);
        const Inside inside(*bodies.held, call);
        return all.set_motion(ids, to, along);
    }
    const std::size_t count = poses.size();
    if (count < 2) refuse_value({call, "pose"}, "expected one pose, or at least two, got " + std::to_string(count));
    const py::array when = times.is_none() ? py::array() : doubles(times, {call, "times"});
    if (!times.is_none() && !has_shape(when, {static_cast<py::ssize_t>(count)}))
        refuse_value({call, "times"}, "expected one per pose, " + std::to_string(count) + ", got " + shape_of(when));
    const auto* const given = static_cast<const double*>(when.data());
    std::vector<RigidMotion::Key> keys;
    for (std::size_t i = 0; i < count; ++i)
        keys.push_back({times.is_none() ? double(i) / double(count - 1) : given[i], poses[i]});
    const RigidMotion motion(keys, along);
    const Inside inside(*bodies.held, call);
    all.set_motion(ids[0], motion);
}

void set_filter(BodiesView& bodies, py::handle which, py::handle layer, py::handle mask, py::handle group)
{
    const char* const call = "bodies.set_filter";
    const auto given = [&](py::handle value, const char* argument) {
        return value.is_none() ? std::nullopt : std::optional(bits(value, {call, argument}));
    };
    const std::optional<std::uint32_t> on = given(layer, "layer"), with = given(mask, "mask"),
                                       of = given(group, "group");
    change(bodies, call, which, [&](Bodies& all, std::span<const BodyId> ids) {
        std::vector<CollisionFilter> filters;
        for (const BodyId id : ids) {
            const CollisionFilter old = all.filter(id);
            filters.push_back({on.value_or(old.layer), with.value_or(old.mask), of.value_or(old.group)});
        }
        for (std::size_t i = 0; i < ids.size(); ++i) all.set_filter(ids[i], filters[i]);
    });
}

void set_user(BodiesView& bodies, py::handle which, py::handle user)
{
    const char* const call = "bodies.set_user";
    const Ids ids(which, {call, "body"}), numbers(user, {call, "user"}); // an id is any number of 64 bits
    Lengths lengths(call);
    lengths.add("body", ids.one(), ids.size()), lengths.add("user", numbers.one(), numbers.size());
    Bodies& all = bodies.held->world.bodies();
    const Inside inside(*bodies.held, call);
    for (const BodyId id : ids) all.user(id); // throws before anything is set
    for (std::size_t i = 0; i < ids.size(); ++i) all.set_user(ids[i], number_of(numbers[i]));
}

void bind_states(py::class_<BodiesView>& bodies)
{
    using namespace py::literals;
    define(
        bodies, "set_static",
        [](BodiesView& view, py::handle which, py::handle is_static) {
            const bool now = truth(is_static, {"bodies.set_static", "static"});
            change(view, "bodies.set_static", which, [&](Bodies& all, BodySpan ids) { all.set_static(ids, now); });
        },
        R"(Makes a body static or dynamic, or many.

Two static bodies never form a pair; a static body may still be moved.)",
        "body"_a, "static"_a);
    define(bodies, "is_static", reader("bodies.is_static", &Bodies::is_static),
           "True if the body is static; for many bool (N,).", "body"_a);
    define(
        bodies, "sleep", changer("bodies.sleep", &Bodies::sleep),
        R"(Puts a body to sleep, or many: a pair of two bodies that are each asleep or static keeps its result untested.

A change of its pose, filter or model wakes a body.)",
        "body"_a);
    define(bodies, "wake", changer("bodies.wake", &Bodies::wake), "Undoes sleep().", "body"_a);
    define(bodies, "is_asleep", reader("bodies.is_asleep", &Bodies::is_asleep),
           "True if the body is asleep; for many bool (N,).", "body"_a);
    define(
        bodies, "filter",
        [](BodiesView& view, py::handle which) {
            const BodyId id = body(which, {"bodies.filter", "body"});
            const Looking looking(*view.held, "bodies.filter");
            const CollisionFilter filter = view.held->world.bodies().filter(id);
            return py::dict("layer"_a = filter.layer, "mask"_a = filter.mask, "group"_a = filter.group);
        },
        R"(The filter of a body: a dict of layer, mask and group.

set_filter(other, **filter(body)) gives another body the same filter, and queries of world.space take it, too.)",
        "body"_a);
    define(bodies, "set_filter", &set_filter, "Sets the filter of a body, or of many, as in add(). None: unchanged.",
           "body"_a, "layer"_a = py::none(), "mask"_a = py::none(), "group"_a = py::none());
    const auto two = [&](const char* name, const char* call, void (Bodies::*method)(BodyId, BodyId), const char* text) {
        define(
            bodies, name,
            [call, method](BodiesView& view, py::handle a, py::handle b) {
                const BodyId first = body(a, {call, "a"}), second = body(b, {call, "b"});
                const Inside inside(*view.held, call);
                (view.held->world.bodies().*method)(first, second);
            },
            text, "a"_a, "b"_a);
    };
    two("exclude", "bodies.exclude", &Bodies::exclude,
        "These two bodies never form a pair, until include() or until one is removed.");
    two("include", "bodies.include", &Bodies::include, "Undoes exclude().");
    define(
        bodies, "excluded",
        [](BodiesView& view, py::handle a, py::handle b) {
            const char* const call = "bodies.excluded";
            const BodyId first = body(a, {call, "a"}), second = body(b, {call, "b"});
            const Looking looking(*view.held, call);
            return view.held->world.bodies().excluded(first, second);
        },
        "True if exclude() keeps the two from forming a pair.", "a"_a, "b"_a);
}

} // namespace

void bind_bodies(py::module_& m)
{
    using namespace py::literals;
    py::class_<BodiesView> bodies(m, "Bodies", R"(The bodies of a World, as World.bodies.

`body` in calls is an id, or ids (N,). For ids a call sets one value for all or (N,), and returns an array.)");
    bodies.def(py::init<HeldWorld&>());
    refuse_pickles(bodies, "Bodies", "they are of one World");
    const SharedArguments with;
    define(bodies, "add", &add_body,
           R"(Adds a body and returns its id (int), or a body for each of many poses: ids, uint64 (N,).

static: two static bodies never form a pair; a static body may still be moved. layer, mask: bits; a pair is tested if the
layer of each has a bit in common with the mask of the other. group: bodies of one group other than 0 never collide; to
keep only neighbours apart, as the links of a robot, use exclude(). user: any number up to 2^64 - 1, which user() returns.)",
           "model"_a, "pose"_a = py::none(), "static"_a = false, with.layer, with.mask, with.group, "user"_a = 0);
    define(
        bodies, "reserve",
        [](BodiesView& view, py::handle count) {
            const std::uint32_t room = bits(count, {"bodies.reserve", "count"});
            const Inside inside(*view.held, "bodies.reserve");
            view.held->world.bodies().reserve(room);
        },
        "Makes room for this number of bodies in all.", "count"_a);
    define(bodies, "remove", changer("bodies.remove", &Bodies::remove),
           "Removes a body, or many, each once. Their ids are stale from now on.", "body"_a);
    define(bodies, "pose", &pose_of, "The pose of a body: float64 (4, 4), a copy; for many (N, 4, 4).", "body"_a);
    define(bodies, "set_pose", &set_pose,
           "Moves a body, or many. pose: metres, rigid to 1e-6. If one of many is invalid, none moves.", "body"_a,
           "pose"_a);
    define(
        bodies, "set_motion", &set_motion,
        R"(Moves a body as set_pose() does, or many, and lets the next step() report contacts on the way, in Frame.sweeps.

A body moves from its pose so far to `pose`, over the time from 0 to 1; one body may also move through many poses, (K, 4,
4) or (K, 7), at least two, from the first to the last. times: of these, float64 (K,), ascending from 0 to 1; None: evenly
spaced. path: from each pose to the next, "linear" or "screw", as in pairs.sweep().)",
        "body"_a, "pose"_a, "times"_a = py::none(), with.path);
    bind_states(bodies);
    define(
        bodies, "model",
        [](BodiesView& view, py::handle which) {
            const BodyId id = body(which, {"bodies.model", "body"});
            const Looking looking(*view.held, "bodies.model");
            return ModelHandle{view.held->world.bodies().model(id)};
        },
        "The Model of one body.", "body"_a);
    define(
        bodies, "set_model",
        [](BodiesView& view, py::handle which, py::handle model) {
            const ModelId id = model_of(model, {"bodies.set_model", "model"});
            change(view, "bodies.set_model", which, [&](Bodies& all, BodySpan ids) { all.set_model(ids, id); });
        },
        "Gives a body another model, or many.", "body"_a, "model"_a);
    define(bodies, "user", reader("bodies.user", &Bodies::user),
           "The number stored with a body (int); for many uint64 (N,).", "body"_a);
    define(bodies, "set_user", &set_user, "Stores any number up to 2^64 - 1 with a body, or numbers with many.",
           "body"_a, "user"_a);
    define(
        bodies, "at",
        [](BodiesView& view, py::handle slot) -> py::object {
            const std::uint32_t number = bits(slot, {"bodies.at", "slot"});
            const Looking looking(*view.held, "bodies.at");
            const BodyId id = view.held->world.bodies().at(number);
            return id ? py::object(py::int_(number_of(id))) : py::none();
        },
        "The id of the body in a slot (int), or None if the slot is free. Bodies take the slots 0, 1, 2 and so on.",
        "slot"_a);
    define(
        bodies, "__contains__",
        [](BodiesView& view, py::handle which) {
            const BodyId id = body(which, {"bodies.__contains__", "body"});
            const Looking looking(*view.held, "bodies.__contains__");
            return view.held->world.bodies().contains(id);
        },
        "True if there is a body with this id.", "body"_a);
    define(
        bodies, "__len__",
        [](BodiesView& view) {
            const Looking looking(*view.held, "bodies.__len__");
            return view.held->world.bodies().size();
        },
        "Number of bodies.");
}

} // namespace oncollide::python
