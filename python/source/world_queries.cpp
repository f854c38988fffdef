// Queries, contacts and distances of a World.
#include <cstring>

#include <fmt/format.h>

#include "held_world.hpp"

namespace oncollide::python {

namespace {

QueryFilter filter_of(py::handle layer, py::handle mask, py::handle group, const char* call)
{
    return {bits(layer, {call, "layer"}), bits(mask, {call, "mask"}), bits(group, {call, "group"})};
}

/// The begin of each item's entries, from their ends; one more than there are items.
py::array offsets_of(const std::vector<std::size_t>& ends)
{
    py::array_t<std::int64_t> made(static_cast<py::ssize_t>(ends.size() + 1));
    made.mutable_at(0) = 0;
    for (std::size_t i = 0; i < ends.size(); ++i)
        made.mutable_at(static_cast<py::ssize_t>(i + 1)) = static_cast<std::int64_t>(ends[i]);
    return made;
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
    return array_of(result_types().hit, std::move(hits));
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
    return py::make_tuple(array_of(result_types().hit, std::move(hits.hits)), offsets_of(hits.ends));
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
    return array_of(result_types().contact, std::move(found));
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
    return py::make_tuple(array_of(result_types().contact, std::move(lists.contacts)), offsets_of(lists.ends));
}

py::object distance(HeldWorld& held, py::handle a, py::handle b, py::handle tolerance, py::handle farthest)
{
    const char* const call = "World.distance";
    const BodyId first = body(a, {call, "a"}), second = body(b, {call, "b"});
    const double within = number(tolerance, {call, "tolerance"}), limit = limit_of(farthest, {call, "farthest"});
    Distance found;
    {
        const Looking looking(held, call);
        const Released released;
        found = held.world.distance(first, second, within, limit);
    }
    py::array made(result_types().distance, py::ssize_t{1});
    std::memcpy(made.mutable_data(), static_cast<const void*>(&found), sizeof found);
    return made[py::int_(0)];
}

} // namespace

void bind_world_queries(WorldClass& world)
{
    using namespace py::literals;
    const auto none = py::none();
    const py::int_ all(0xffffffffu);
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

Finds the bodies that a body of this model at this pose would hit, without adding it.

Returns a structured array (N,), sorted by slot: body (uint64), verdict (uint8, never separate), kind (uint8), bound
(float64, metres).)");
    world.def("query_batch", &query_batch, "model"_a, "poses"_a, "layer"_a = 1, "mask"_a = all, "group"_a = 0,
              R"(query_batch(self, model, poses, layer=1, mask=4294967295, group=0)
--

The same at many poses, (N, 4, 4) or (N, 7), on the World's threads.

Returns (hits, offsets): the hits of pose i are hits[offsets[i]:offsets[i + 1]]; offsets is int64 (N + 1,).)");
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

Finds the bodies that a segment touches. start, end: (3,) metres. Returns as query(), not sorted along the segment.)");
    world.def(
        "query_box",
        [](HeldWorld& held, py::handle low, py::handle high, py::handle layer, py::handle mask, py::handle group) {
            const char* const call = "World.query_box";
            return hits_of(held, call, box_of(low, high, call), filter_of(layer, mask, group, call));
        },
        "low"_a, "high"_a, "layer"_a = 1, "mask"_a = all, "group"_a = 0,
        R"(query_box(self, low, high, layer=1, mask=4294967295, group=0)
--

Finds the bodies that touch a solid box along the world's axes. low, high: (3,) metres, its corners. Returns as query().)");
    world.def("contacts", &contacts, "a"_a, "b"_a, R"(contacts(self, a, b)
--

All pairs of parts of two bodies that meet, at their present poses.

Returns a structured array (N,): triangle_a, triangle_b (uint32, indices of triangles; 0 for other parts), cell_a,
cell_b (int32 (4,): for maps the cube's x, y, z and side, in cells), kind (uint8, a ContactKind), ends (float64 (2, 3):
for two triangles the segment that both share, else a point on each part), normal_a, normal_b (float64 (3,), unit).
World frame, metres.)");
    world.def("contacts_batch", &contacts_batch, "a"_a, "b"_a, R"(contacts_batch(self, a, b)
--

The same for many pairs, on the World's threads. a, b: (N,) ids.

Returns (contacts, offsets): pair i has contacts[offsets[i]:offsets[i + 1]]; offsets is int64 (N + 1,).)");
    world.def("distance", &distance, "a"_a, "b"_a, "tolerance"_a = 0.0, "farthest"_a = none,
              R"(distance(self, a, b, tolerance=0.0, farthest=None)
--

Certified bounds on the distance of two bodies, and their nearest points.

tolerance: metres, >= 0; a larger tolerance is cheaper. farthest: the cutoff, metres; beyond it lower > farthest and
upper = inf; None: no cutoff.
Returns a structured scalar: lower, upper (float64, metres; both 0 if they meet), triangle_a, cell_a, triangle_b, cell_b
(as in contacts()), point_a, point_b (float64 (3,), world frame, if upper is finite).)");
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

The error bound of `within` for these two bodies, metres above the clearance (float).)");
}

} // namespace oncollide::python
