// World and the frames that it runs.
#include <atomic>
#include <thread>

#include <fmt/format.h>

#include <oncollide/pipeline/world.hpp>

#include "bindings.hpp"
#include "release.hpp"

namespace oncollide::python {

namespace {

/// A model as Python holds it: of one World, so that no other takes it.
struct ModelHandle {
    std::uint64_t world;
    ModelId id;
    friend bool operator==(const ModelHandle&, const ModelHandle&) = default;
};

std::uint64_t next_world()
{
    static std::atomic<std::uint64_t> worlds = 0;
    return ++worlds;
}

/// The World, who is inside it, and the thread that it belongs to.
struct HeldWorld {
    Interrupts interrupts;
    World world;
    const std::uint64_t number = next_world();
    Users users;
    const bool tied; ///< to its thread, by a GPU
    const std::thread::id home = std::this_thread::get_id();

    explicit HeldWorld(const Settings& settings)
        : world(with_stop(settings)), tied(settings.backend != BackendKind::cpu)
    {
    }
    Settings with_stop(Settings settings)
    {
        settings.stop = [this] { return interrupts.requested(); };
        return settings;
    }

    void at_home(const char* call) const
    {
        if (tied && std::this_thread::get_id() != home)
            throw Error(ErrorKind::usage, fmt::format("{}: a World with a GPU backend belongs to the thread that made "
                                                      "it; call it from there, or make it with backend='cpu'",
                                                      call));
    }
};

/// Alone in a World for one call.
struct Inside : Users::Alone {
    Inside(HeldWorld& held, const char* call) : Alone(held.users, call) { held.at_home(call); }
};
/// Beside other const calls.
struct Looking : Users::Beside {
    Looking(HeldWorld& held, const char* call) : Beside(held.users, call) { held.at_home(call); }
};

ModelId model_of(const HeldWorld& held, py::handle value, const Place& place)
{
    if (!py::isinstance<ModelHandle>(value)) refuse_type(place, "a Model, as World.add() returns it", value);
    const auto& model = py::cast<const ModelHandle&>(value);
    if (model.world != held.number)
        refuse_value(place, "this model is of another World; add its geometry to this one, which copies nothing");
    return model.id;
}

std::uint32_t bits(py::handle value, const Place& place)
{
    return static_cast<std::uint32_t>(whole(value, place, 0xffffffffu));
}

QueryFilter filter_of(py::handle layer, py::handle mask, py::handle group, const char* call)
{
    return {bits(layer, {call, "layer"}), bits(mask, {call, "mask"}), bits(group, {call, "group"})};
}

Aabb box_of(py::handle low, py::handle high, const char* call)
{
    return {vector3(low, {call, "low"}), vector3(high, {call, "high"})};
}

CellState state_of(py::handle value, const char* call)
{
    const Place place{call, "state"};
    const std::string name = text(value, place);
    if (name == "unknown") return CellState::unknown;
    if (name == "free") return CellState::free;
    if (name == "occupied") return CellState::occupied;
    refuse_value(place, "no '" + printable(name) + "'; valid: unknown, free, occupied");
}

/// What one step found; a copy of what the World will overwrite.
struct FrameResult {
    std::uint64_t frame, hash;
    double ms;
    std::vector<PairResult> pairs;
    std::vector<PairOfBodies> began, ended;
    std::vector<StageStats> stages;
    TreeStats trees;

    explicit FrameResult(const FrameView& view)
        : frame(view.frame), hash(view.hash), ms(view.ms), pairs(view.pairs.begin(), view.pairs.end()),
          began(view.began.begin(), view.began.end()), ended(view.ended.begin(), view.ended.end()),
          stages(view.stages.begin(), view.stages.end()), trees(view.trees)
    {
    }
};

/// A view of what the frame holds, which keeps the frame alive.
template <auto member, auto type>
py::array column(py::object self)
{
    const auto& items = self.cast<const FrameResult&>().*member;
    return py::array(type(), {static_cast<py::ssize_t>(items.size())}, {}, items.data(), self);
}

py::dict stage_dict(const StageStats& s)
{
    using namespace py::literals;
    return py::dict("stage"_a = s.stage, "unit"_a = s.unit, "frames"_a = s.frames, "in"_a = s.in, "out"_a = s.out,
                    "culled"_a = s.culled, "undecided"_a = s.undecided, "cpu_ms"_a = s.cpu_ms, "gpu_ms"_a = s.gpu_ms,
                    "wait_ms"_a = s.wait_ms, "skipped"_a = s.skipped, "note"_a = s.note);
}

py::list stage_list(std::span<const StageStats> stages)
{
    py::list made;
    for (const StageStats& stage : stages) made.append(stage_dict(stage));
    return made;
}

/// Where each item's begin, from `ends`: one more than there are items.
py::array offsets_of(const std::vector<std::size_t>& ends)
{
    py::array_t<std::int64_t> made(static_cast<py::ssize_t>(ends.size() + 1));
    made.mutable_at(0) = 0;
    for (std::size_t i = 0; i < ends.size(); ++i)
        made.mutable_at(static_cast<py::ssize_t>(i + 1)) = static_cast<std::int64_t>(ends[i]);
    return made;
}

std::size_t same_length(const Poses& poses, std::size_t others, const Place& place)
{
    if (!poses.one() && poses.size() != others)
        refuse_value(place, fmt::format("{} poses for {}; must be as many, or one for all", poses.size(), others));
    return others;
}

py::object add_body(HeldWorld& held, py::handle model, py::handle at, py::handle fixed, py::handle layer,
                    py::handle mask, py::handle group, py::handle user)
{
    const char* const call = "World.add_body";
    const BodySpec spec{.model = model_of(held, model, {call, "model"}),
                        .pose = pose(at, {call, "pose"}),
                        .fixed = truth(fixed, {call, "fixed"}),
                        .layer = bits(layer, {call, "layer"}),
                        .mask = bits(mask, {call, "mask"}),
                        .group = bits(group, {call, "group"}),
                        .user = whole(user, {call, "user"}, ~0ull)};
    const Inside inside(held, call);
    return py::int_(number_of(held.world.add_body(spec)));
}

py::array add_bodies(HeldWorld& held, py::handle model, py::handle at, py::handle fixed, py::handle layer,
                     py::handle mask, py::handle group)
{
    const char* const call = "World.add_bodies";
    const BodySpec spec{.model = model_of(held, model, {call, "model"}),
                        .fixed = truth(fixed, {call, "fixed"}),
                        .layer = bits(layer, {call, "layer"}),
                        .mask = bits(mask, {call, "mask"}),
                        .group = bits(group, {call, "group"})};
    const Poses poses(at, {call, "poses"});
    std::vector<BodySpec> specs(poses.size(), spec);
    for (std::size_t i = 0; i < specs.size(); ++i) specs[i].pose = poses[i];
    std::vector<BodyId> ids(specs.size());
    const Inside inside(held, call);
    held.world.add_bodies(specs, ids);
    return ids_of(ids);
}

void set_poses(HeldWorld& held, py::handle which, py::handle at)
{
    const char* const call = "World.set_poses";
    const std::vector<BodyId> ids = bodies(which, {call, "bodies"});
    const Poses poses(at, {call, "poses"});
    same_length(poses, ids.size(), {call, "poses"});
    std::vector<Eigen::Isometry3d> made(ids.size());
    for (std::size_t i = 0; i < ids.size(); ++i) made[i] = poses[i];
    const Inside inside(held, call);
    held.world.set_poses(ids, made);
}

py::array pose_of(HeldWorld& held, py::handle which)
{
    const BodyId id = body(which, {"World.pose", "body"});
    const Looking looking(held, "World.pose");
    py::array_t<double> made({4, 4});
    Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(made.mutable_data()) = held.world.pose(id).matrix();
    return made;
}

std::unique_ptr<FrameResult> step(HeldWorld& held)
{
    std::unique_ptr<FrameResult> found;
    {
        const Inside inside(held, "World.step");
        const Released released(&held.interrupts);
        found = std::make_unique<FrameResult>(held.world.step());
    }
    held.interrupts.rethrow();
    return found;
}

template <class... Query>
py::array hits_of(HeldWorld& held, const char* call, const Query&... query)
{
    std::vector<QueryHit> hits;
    {
        const Looking looking(held, call);
        const Released released;
        hits = held.world.query(query...);
    }
    return array_of(hit_type(), std::move(hits));
}

py::tuple query_batch(HeldWorld& held, py::handle model, py::handle at, py::handle layer, py::handle mask,
                      py::handle group)
{
    const char* const call = "World.query_batch";
    const ModelQuery query{.model = model_of(held, model, {call, "model"}),
                           .filter = filter_of(layer, mask, group, call)};
    const Poses poses(at, {call, "poses"});
    QueryHits hits;
    {
        const Looking looking(held, call);
        const Released released;
        std::vector<ModelQuery> queries(poses.size(), query);
        for (std::size_t i = 0; i < queries.size(); ++i) queries[i].pose = poses[i];
        held.world.query(queries, hits);
    }
    return py::make_tuple(array_of(hit_type(), std::move(hits.hits)), offsets_of(hits.ends));
}

py::array contacts(HeldWorld& held, py::handle a, py::handle b)
{
    const char* const call = "World.contacts";
    const BodyId first = body(a, {call, "a"}), second = body(b, {call, "b"});
    std::vector<Contact> found;
    {
        const Looking looking(held, call);
        const Released released;
        found = held.world.contacts(first, second);
    }
    return array_of(contact_type(), std::move(found));
}

py::tuple contacts_batch(HeldWorld& held, py::handle a, py::handle b)
{
    const char* const call = "World.contacts_batch";
    const std::vector<BodyId> firsts = bodies(a, {call, "a"}), seconds = bodies(b, {call, "b"});
    if (firsts.size() != seconds.size())
        refuse_value({call, "b"}, fmt::format("{} bodies for {} of a; must be as many", seconds.size(), firsts.size()));
    ContactLists lists;
    {
        const Looking looking(held, call);
        const Released released;
        std::vector<PairOfBodies> pairs;
        for (std::size_t i = 0; i < firsts.size(); ++i) pairs.push_back({firsts[i], seconds[i]});
        held.world.contacts(pairs, lists);
    }
    return py::make_tuple(array_of(contact_type(), std::move(lists.contacts)), offsets_of(lists.ends));
}

py::object distance(HeldWorld& held, py::handle a, py::handle b, py::handle tolerance, py::handle farthest)
{
    const char* const call = "World.distance";
    const BodyId first = body(a, {call, "a"}), second = body(b, {call, "b"});
    const double within = number(tolerance, {call, "tolerance"}), limit = limit_of(farthest, {call, "farthest"});
    std::vector<Distance> found(1);
    {
        const Looking looking(held, call);
        const Released released;
        found[0] = held.world.distance(first, second, within, limit);
    }
    return array_of(distance_type(), std::move(found))[py::int_(0)];
}

/// A method of one body that changes it.
template <class Change>
void change(HeldWorld& held, const char* call, py::handle which, Change work)
{
    const BodyId id = body(which, {call, "body"});
    const Inside inside(held, call);
    work(id);
}

/// A property or a method that only looks.
template <class Look>
auto look(const char* call, Look work)
{
    return [call, work](HeldWorld& held) {
        const Looking looking(held, call);
        return work(held.world);
    };
}

} // namespace

void bind_world(py::module_& m)
{
    using namespace py::literals;
    const auto none = py::none();
    const py::int_ all(0xffffffffu);

    py::class_<ModelHandle>(m, "Model",
                            R"(A geometry in one World, with all that is derived from it; as World.add() returns it.)")
        .def("__eq__",
             [](const ModelHandle& a, py::handle b) {
                 return py::isinstance<ModelHandle>(b) && a == py::cast<const ModelHandle&>(b);
             })
        .def(
            "__hash__",
            [](const ModelHandle& model) { return model.world * 0x9e3779b97f4a7c15u ^ std::hash<ModelId>()(model.id); })
        .def("__repr__", [](const ModelHandle& model) {
            return fmt::format("<oncollide.Model {} of World {}>", model.id.slot, model.world);
        });

    py::class_<FrameResult>(
        m, "Frame", R"(What one World.step() found. Its arrays are its own: later steps leave them as they are.)")
        .def_readonly("frame", &FrameResult::frame, "Counted from 0 by the World (int).")
        .def_readonly("ms", &FrameResult::ms, "How long the step took, milliseconds (float).")
        .def_readonly("hash", &FrameResult::hash,
                      "Of the pairs that are not separate; equal input gives an equal hash (int).")
        .def_property_readonly("pairs", &column<&FrameResult::pairs, pair_type>,
                               R"(Every pair whose boxes overlap, separate ones too, sorted by the slots of a and b.

Structured (N,): a, b (uint64, ids of bodies), verdict (uint8, a Verdict), stage (uint8, index into World.stages), kind
(uint8, a ContactKind), bound (float64, metres; separate: certified lower bound on the distance; within and undecided:
certified upper bound; colliding: 0).)")
        .def_property_readonly(
            "began", &column<&FrameResult::began, bodies_type>,
            "Pairs that are not separate, and were in the step before: structured (N,), a, b (uint64).")
        .def_property_readonly("ended", &column<&FrameResult::ended, bodies_type>,
                               "The reverse, also where a body was removed: structured (N,), a, b (uint64).")
        .def_property_readonly(
            "stages", [](const FrameResult& f) { return stage_list(f.stages); },
            "What each stage did: dicts with stage, unit, in, out, culled, undecided, cpu_ms and others.")
        .def_property_readonly(
            "trees",
            [](const FrameResult& f) {
                const TreeStats& t = f.trees;
                return py::dict("rounds"_a = t.rounds, "rows"_a = t.rows, "node_pairs"_a = t.node_pairs,
                                "triangle_pairs"_a = t.triangle_pairs, "narrowed"_a = t.narrowed, "by_gap"_a = t.by_gap,
                                "by_witness"_a = t.by_witness, "nodes"_a = t.nodes, "collapsed"_a = t.collapsed,
                                "refused"_a = t.refused, "bytes"_a = t.bytes);
            },
            "What refinement did: a dict of counts.")
        .def("__repr__", [](const FrameResult& f) {
            return fmt::format("<oncollide.Frame {}: {} pairs, {} began, {} ended>", f.frame, f.pairs.size(),
                               f.began.size(), f.ended.size());
        });

    py::class_<HeldWorld> world(m, "World", R"(World(**settings)
--

Bodies and their models, which come, go and move between steps, and which of them collide.

    world = oncollide.World(max_error=0.01)
    crane = world.add(oncollide.load_mesh("crane.obj"))
    body = world.add_body(crane, pose=np.eye(4))
    for pair in world.step().pairs: ...

Settings, all by keyword:
  max_error: metres, > 0; bodies reported `within` are closer than clearance + max_error. None: 1 % of the smaller body.
  depth: 1 to 16, the depth of sphere-trees, in place of max_error.
  clearance: metres, >= 0; pairs this close count as touching.
  exact: 'off', 'predicates' (decides exactly whether surfaces meet) or 'fcl'.
  contact_kinds, ignore_touching: tell touching from crossing; leave pairs that only touch apart. exact='predicates'.
  mode: 'surface' or 'solid' (the inside of a closed mesh belongs to it). open_as_surface: takes open meshes, too.
  threads: 1; 0: all that there are. Never changes a result.
  bounding_volume: 'auto', 'sphere' or 'obb'. broad_phase: 'kd', 'octree' or 'brute'.
  backend: 'cpu', 'auto', 'gl-compute' or 'gl-query'; gpu, viewport: for these.
  skip: names of stages to leave out. age_limit, node_budget, memory_budget, coherence: as in the C++ library.

Bodies have ids, whole numbers. That of a removed body is stale: using it raises Error. Poses are float64: (4, 4), body
to world, metres, or (7,) with position and quaternion x y z qx qy qz qw.

Raises TypeError and ValueError for arguments of another type, shape or range, and Error for what the library refuses;
then nothing has changed. One thread at a time may change a World, or step it; queries, contacts and distances may run
side by side. Calls that compute let other threads of Python run.)");

    world.def(py::init(
        [](const py::kwargs& settings) { return std::make_unique<HeldWorld>(settings_of(settings, "World")); }));

    world.def(
        "add",
        [](HeldWorld& held, py::handle made) {
            GeometryHandle shared = geometry(made, {"World.add", "geometry"});
            const Inside inside(held, "World.add");
            return ModelHandle{held.number, held.world.add(std::move(shared))};
        },
        "geometry"_a, R"(add(self, geometry)
--

Shares a Geometry with this World and returns its Model. Builds nothing yet: trees grow where bodies come close.)");
    world.def(
        "replace",
        [](HeldWorld& held, py::handle model, py::handle made) {
            const ModelId id = model_of(held, model, {"World.replace", "model"});
            GeometryHandle shared = geometry(made, {"World.replace", "geometry"});
            const Inside inside(held, "World.replace");
            held.world.replace(id, std::move(shared));
        },
        "model"_a, "geometry"_a, R"(replace(self, model, geometry)
--

Gives a model another Geometry; all its bodies have it from now on.)");
    world.def(
        "remove",
        [](HeldWorld& held, py::handle model) {
            const ModelId id = model_of(held, model, {"World.remove", "model"});
            const Inside inside(held, "World.remove");
            held.world.remove(id);
        },
        "model"_a, R"(remove(self, model)
--

Removes a model. Raises Error while a body uses it.)");

    world.def("add_body", &add_body, "model"_a, "pose"_a = none, "fixed"_a = false, "layer"_a = 1, "mask"_a = all,
              "group"_a = 0, "user"_a = 0,
              R"(add_body(self, model, pose=None, fixed=False, layer=1, mask=4294967295, group=0, user=0)
--

Adds a body and returns its id (int).

pose: (4, 4) or (7,), metres; None: the origin. fixed: two fixed bodies never form a pair. layer, mask: bits; a pair is
tested when the layer of each has a bit in common with the mask of the other. group: bodies of one group other than 0
never collide. user: a number of yours, up to 2^64 - 1, which World.user() returns.)");
    world.def("add_bodies", &add_bodies, "model"_a, "poses"_a, "fixed"_a = false, "layer"_a = 1, "mask"_a = all,
              "group"_a = 0, R"(add_bodies(self, model, poses, fixed=False, layer=1, mask=4294967295, group=0)
--

Adds a body for each of the poses, (N, 4, 4) or (N, 7), and returns their ids, uint64 (N,).)");
    world.def(
        "remove_body",
        [](HeldWorld& held, py::handle which) {
            change(held, "World.remove_body", which, [&](BodyId id) { held.world.remove_body(id); });
        },
        "body"_a, R"(remove_body(self, body)
--

Removes a body; its id is stale from now on.)");
    world.def(
        "remove_bodies",
        [](HeldWorld& held, py::handle which) {
            const std::vector<BodyId> ids = bodies(which, {"World.remove_bodies", "bodies"});
            const Inside inside(held, "World.remove_bodies");
            held.world.remove_bodies(ids);
        },
        "bodies"_a, R"(remove_bodies(self, bodies)
--

Removes bodies, each once. bodies: (N,) ids.)");

    world.def(
        "set_pose",
        [](HeldWorld& held, py::handle which, py::handle at) {
            const Eigen::Isometry3d to = pose(at, {"World.set_pose", "pose"});
            change(held, "World.set_pose", which, [&](BodyId id) { held.world.set_pose(id, to); });
        },
        "body"_a, "pose"_a, R"(set_pose(self, body, pose)
--

Moves a body. pose: (4, 4) or (7,), metres; rigid to 1e-6.)");
    world.def("set_poses", &set_poses, "bodies"_a, "poses"_a, R"(set_poses(self, bodies, poses)
--

Moves many. bodies: (N,) ids. poses: (N, 4, 4) or (N, 7), metres, or one pose for all. Where one is refused, none moves.)");
    world.def(
        "set_fixed",
        [](HeldWorld& held, py::handle which, py::handle fixed) {
            const bool now = truth(fixed, {"World.set_fixed", "fixed"});
            change(held, "World.set_fixed", which, [&](BodyId id) { held.world.set_fixed(id, now); });
        },
        "body"_a, "fixed"_a, R"(set_fixed(self, body, fixed)
--

Two fixed bodies never form a pair; a fixed body may be moved all the same.)");
    world.def(
        "set_layers",
        [](HeldWorld& held, py::handle which, py::handle layer, py::handle mask) {
            const char* const call = "World.set_layers";
            const std::uint32_t on = bits(layer, {call, "layer"}), with = bits(mask, {call, "mask"});
            change(held, call, which, [&](BodyId id) { held.world.set_layers(id, on, with); });
        },
        "body"_a, "layer"_a, "mask"_a, R"(set_layers(self, body, layer, mask)
--

The layers that a body is on, and those that it collides with: bits.)");
    world.def(
        "set_group",
        [](HeldWorld& held, py::handle which, py::handle group) {
            const std::uint32_t of = bits(group, {"World.set_group", "group"});
            change(held, "World.set_group", which, [&](BodyId id) { held.world.set_group(id, of); });
        },
        "body"_a, "group"_a, R"(set_group(self, body, group)
--

Bodies of one group other than 0 never collide.)");
    world.def(
        "set_model",
        [](HeldWorld& held, py::handle which, py::handle model) {
            const ModelId id = model_of(held, model, {"World.set_model", "model"});
            change(held, "World.set_model", which, [&](BodyId body) { held.world.set_model(body, id); });
        },
        "body"_a, "model"_a, R"(set_model(self, body, model)
--

Gives a body another model.)");
    world.def(
        "set_user",
        [](HeldWorld& held, py::handle which, py::handle user) {
            const std::uint64_t now = whole(user, {"World.set_user", "user"}, ~0ull);
            change(held, "World.set_user", which, [&](BodyId id) { held.world.set_user(id, now); });
        },
        "body"_a, "user"_a, R"(set_user(self, body, user)
--

A number of yours, up to 2^64 - 1, that the World keeps for a body.)");
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

Where a body is: float64 (4, 4), a copy.)");
    world.def(
        "model",
        [](HeldWorld& held, py::handle which) {
            const BodyId id = body(which, {"World.model", "body"});
            const Looking looking(held, "World.model");
            return ModelHandle{held.number, held.world.model(id)};
        },
        "body"_a, R"(model(self, body)
--

The Model of a body.)");
    world.def(
        "user",
        [](HeldWorld& held, py::handle which) {
            const BodyId id = body(which, {"World.user", "body"});
            const Looking looking(held, "World.user");
            return held.world.user(id);
        },
        "body"_a, R"(user(self, body)
--

The number of yours that the World keeps for a body (int).)");
    world.def(
        "fixed",
        [](HeldWorld& held, py::handle which) {
            const BodyId id = body(which, {"World.fixed", "body"});
            const Looking looking(held, "World.fixed");
            return held.world.fixed(id);
        },
        "body"_a, R"(fixed(self, body)
--

Is the body fixed?)");
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

Is there a body with this id, or this Model?)");
    world.def("__len__", look("World.__len__", [](const World& w) { return w.size(); }), R"(__len__(self, /)
--

How many bodies there are.)");

    world.def("step", &step, R"(step(self)
--

Finds all pairs as the bodies are now, and returns a Frame. Lets other threads of Python run meanwhile.

Ctrl-C ends it soon, between two pairs, with KeyboardInterrupt; the World stays valid, and the next step is whole.)");

    world.def(
        "query",
        [](HeldWorld& held, py::handle model, py::handle at, py::handle layer, py::handle mask, py::handle group) {
            const char* const call = "World.query";
            return hits_of(held, call, model_of(held, model, {call, "model"}), pose(at, {call, "pose"}),
                           filter_of(layer, mask, group, call));
        },
        "model"_a, "pose"_a = none, "layer"_a = 1, "mask"_a = all, "group"_a = 0,
        R"(query(self, model, pose=None, layer=1, mask=4294967295, group=0)
--

What a body of this model at this pose would hit, without adding one.

Returns a structured array (N,), sorted by slot: body (uint64), verdict (uint8, never separate), kind (uint8), bound
(float64, metres).)");
    world.def("query_batch", &query_batch, "model"_a, "poses"_a, "layer"_a = 1, "mask"_a = all, "group"_a = 0,
              R"(query_batch(self, model, poses, layer=1, mask=4294967295, group=0)
--

The same at many poses, (N, 4, 4) or (N, 7), on the World's threads.

Returns (hits, offsets): those of pose i are hits[offsets[i]:offsets[i + 1]]; offsets is int64 (N + 1,).)");
    world.def(
        "query_segment",
        [](HeldWorld& held, py::handle from, py::handle to, py::handle layer, py::handle mask, py::handle group) {
            const char* const call = "World.query_segment";
            return hits_of(held, call, Segment{vector3(from, {call, "start"}), vector3(to, {call, "end"})},
                           filter_of(layer, mask, group, call));
        },
        "start"_a, "end"_a, "layer"_a = 1, "mask"_a = all, "group"_a = 0,
        R"(query_segment(self, start, end, layer=1, mask=4294967295, group=0)
--

What a segment touches. start, end: (3,) metres. Returns as query(), not sorted along the segment.)");
    world.def(
        "query_box",
        [](HeldWorld& held, py::handle low, py::handle high, py::handle layer, py::handle mask, py::handle group) {
            const char* const call = "World.query_box";
            return hits_of(held, call, box_of(low, high, call), filter_of(layer, mask, group, call));
        },
        "low"_a, "high"_a, "layer"_a = 1, "mask"_a = all, "group"_a = 0,
        R"(query_box(self, low, high, layer=1, mask=4294967295, group=0)
--

What reaches into a solid box of the world. low, high: (3,) metres, its least and greatest corner. Returns as query().)");
    world.def("contacts", &contacts, "a"_a, "b"_a, R"(contacts(self, a, b)
--

All pairs of parts of two bodies that meet, as they are now.

Returns a structured array (N,): triangle_a, triangle_b (uint32, numbers of triangles; 0 of others), cell_a, cell_b
(int32 (4,): of maps the cube's x, y, z and side, in cells), kind (uint8, a ContactKind), ends (float64 (2, 3): of two
triangles the segment that both share, of others a point on each), normal_a, normal_b (float64 (3,), unit). World frame,
metres.)");
    world.def("contacts_batch", &contacts_batch, "a"_a, "b"_a, R"(contacts_batch(self, a, b)
--

The same for many pairs, on the World's threads. a, b: (N,) ids.

Returns (contacts, offsets): those of pair i are contacts[offsets[i]:offsets[i + 1]]; offsets is int64 (N + 1,).)");
    world.def("distance", &distance, "a"_a, "b"_a, "tolerance"_a = 0.0, "farthest"_a = none,
              R"(distance(self, a, b, tolerance=0.0, farthest=None)
--

Certified bounds on the distance of two bodies, and their nearest points.

tolerance: metres, >= 0; a larger one is cheaper. farthest: metres; of bodies beyond it only a lower bound above it is found; None: no limit.
Returns a structured scalar: lower, upper (float64, metres; both 0 where they meet; upper inf beyond `farthest`),
triangle_a, cell_a, triangle_b, cell_b (as contacts()), point_a, point_b (float64 (3,), world, where upper is finite).)");
    world.def(
        "max_error",
        [](HeldWorld& held, py::handle a, py::handle b) {
            const char* const call = "World.max_error";
            const BodyId first = body(a, {call, "a"}), second = body(b, {call, "b"});
            const Looking looking(held, call);
            return held.world.max_error(first, second);
        },
        "a"_a, "b"_a, R"(max_error(self, a, b)
--

The largest error that `within` may have for these two bodies, metres above the clearance (float).)");

    world.def(
        "set_cells",
        [](HeldWorld& held, py::handle map, py::handle at, py::handle state) {
            const char* const call = "World.set_cells";
            const ModelId id = model_of(held, map, {call, "map"});
            const std::vector<Eigen::Vector3d> places = points(at, {call, "points"});
            const CellState to = state_of(state, call);
            const Inside inside(held, call);
            held.world.set_cells(id, places, to);
        },
        "map"_a, "points"_a, "state"_a, R"(set_cells(self, map, points, state)
--

Gives the cells of a map's Model that hold these points another state: 'unknown', 'free' or 'occupied'.

points: (N, 3) metres, in the map's frame. The Geometry stays as it is; this World has a copy from now on.)");
    world.def(
        "set_cells_in_box",
        [](HeldWorld& held, py::handle map, py::handle low, py::handle high, py::handle state) {
            const char* const call = "World.set_cells_in_box";
            const ModelId id = model_of(held, map, {call, "map"});
            const Aabb box = box_of(low, high, call);
            const CellState to = state_of(state, call);
            const Inside inside(held, call);
            held.world.set_cells(id, box, to);
        },
        "map"_a, "low"_a, "high"_a, "state"_a, R"(set_cells_in_box(self, map, low, high, state)
--

The same for the cells whose middles are in a box of the map's frame. low, high: (3,) metres.)");
    world.def(
        "insert_scan",
        [](HeldWorld& held, py::handle map, py::handle at, py::handle origin, py::handle max_range) {
            const char* const call = "World.insert_scan";
            const ModelId id = model_of(held, map, {call, "map"});
            const std::vector<Eigen::Vector3d> places = points(at, {call, "points"});
            const Eigen::Vector3d from = vector3(origin, {call, "origin"});
            const double range = max_range.is_none() ? -1 : number(max_range, {call, "max_range"});
            const Inside inside(held, call);
            const Released released;
            held.world.insert_scan(id, places, from, range);
        },
        "map"_a, "points"_a, "origin"_a, "max_range"_a = none, R"(insert_scan(self, map, points, origin, max_range=None)
--

Takes a sensor's scan into a map's Model, as OctoMap counts hits and misses.

points: (N, 3) metres, in the map's frame. origin: (3,), where the sensor was. max_range: longer rays are cut there and
hit nothing; None: no ray is too long.)");

    world.def_property_readonly("stages",
                                look("World.stages",
                                     [](const World& w) {
                                         py::list names;
                                         for (const std::string_view name : w.stages()) names.append(name);
                                         return py::tuple(names);
                                     }),
                                "Names of the stages in order (tuple of str).");
    world.def_property_readonly("totals", look("World.totals", [](const World& w) { return stage_list(w.totals()); }),
                                "Sums over all frames so far, as Frame.stages.");
    world.def_property_readonly("hash", look("World.hash", [](const World& w) { return w.hash(); }),
                                "Chained over all frames so far; equal input gives an equal hash (int).");
    world.def_property_readonly("bytes", look("World.bytes", [](const World& w) { return w.bytes(); }),
                                "HeldWorld for bodies, boxes and trees, bytes; the geometries come on top (int).");
    world.def_property_readonly("backend", look("World.backend", [](const World& w) { return w.backend(); }),
                                "What finds grey cells, e.g. 'cpu (avx2)' (str).");
    world.def("__repr__", [](const HeldWorld& held) { // also while another thread is inside
        return fmt::format("<oncollide.World {}>", held.number);
    });
}

} // namespace oncollide::python
