// Queries of one thing against all bodies of a World.
#include "held_world.hpp"

namespace oncollide::python {

CollisionFilter filter_of(py::handle layer, py::handle mask, py::handle group, const char* call)
{
    return {bits(layer, {call, "layer"}), bits(mask, {call, "mask"}), bits(group, {call, "group"})};
}

namespace {

template <class... Query>
py::array hits_of(HeldWorld& held, const char* call, const Query&... query)
{
    std::vector<QueryHit> hits;
    {
        const Looking looking(held, call);
        const Released released;
        hits = held.world.space().overlaps(query...);
    }
    return array_of(result_types().hit, std::move(hits));
}

py::tuple query_batch(HeldWorld& held, py::handle model, py::handle at, py::handle layer, py::handle mask,
                      py::handle group)
{
    const char* const call = "World.query_batch";
    const PlacedModel query{.model = model_of(held, model, {call, "model"}),
                            .filter = filter_of(layer, mask, group, call)};
    const Poses poses(at, {call, "poses"});
    Lists<QueryHit> hits;
    {
        const Looking looking(held, call);
        const Released released;
        std::vector<PlacedModel> queries(poses.size(), query);
        for (std::size_t i = 0; i < queries.size(); ++i) queries[i].pose = poses[i];
        held.world.space().overlaps(queries, hits);
    }
    return py::make_tuple(array_of(result_types().hit, std::move(hits.hits)), offsets_of(hits.offsets));
}

std::vector<Segment> segments_of(py::handle from, py::handle to, const char* call)
{
    const std::vector<Eigen::Vector3d> starts = points(from, {call, "starts"}), ends = points(to, {call, "ends"});
    if (starts.size() != ends.size())
        refuse_value({call, "ends"}, "expected as many points as starts, " + std::to_string(starts.size()) + ", got " +
                                         std::to_string(ends.size()));
    std::vector<Segment> segments(starts.size());
    for (std::size_t i = 0; i < segments.size(); ++i) segments[i] = {starts[i], ends[i]};
    return segments;
}

py::tuple query_segments(HeldWorld& held, py::handle from, py::handle to, py::handle layer, py::handle mask,
                         py::handle group)
{
    const char* const call = "World.query_segments";
    const CollisionFilter filter = filter_of(layer, mask, group, call);
    const std::vector<Segment> segments = segments_of(from, to, call);
    Lists<QueryHit> hits;
    {
        const Looking looking(held, call);
        const Released released;
        held.world.space().overlaps(segments, filter, hits);
    }
    return py::make_tuple(array_of(result_types().hit, std::move(hits.hits)), offsets_of(hits.offsets));
}

py::array cast(HeldWorld& held, py::handle from, py::handle to, py::handle layer, py::handle mask, py::handle group)
{
    const char* const call = "World.cast";
    const CollisionFilter filter = filter_of(layer, mask, group, call);
    const std::vector<Segment> segments = segments_of(from, to, call);
    std::vector<CastHit> hits(segments.size());
    {
        const Looking looking(held, call);
        const Released released;
        held.world.space().cast(segments, filter, hits);
    }
    return array_of(result_types().cast, std::move(hits));
}

py::array cast_all(HeldWorld& held, py::handle from, py::handle to, py::handle layer, py::handle mask, py::handle group)
{
    const char* const call = "World.cast_all";
    const CollisionFilter filter = filter_of(layer, mask, group, call);
    const Segment segment{vector3(from, {call, "start"}), vector3(to, {call, "end"})};
    std::vector<CastHit> hits;
    {
        const Looking looking(held, call);
        const Released released;
        hits = held.world.space().cast_all(segment, filter);
    }
    return array_of(result_types().cast, std::move(hits));
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

Finds the bodies that a segment touches. start, end: (3,) metres. Returns as query(), not sorted along the segment.

Results for meshes, terrains, maps, boxes and hulls are exact with all settings.)");
    world.def("query_segments", &query_segments, "starts"_a, "ends"_a, "layer"_a = 1, "mask"_a = all, "group"_a = 0,
              R"(query_segments(self, starts, ends, layer=1, mask=4294967295, group=0)
--

The same for many segments, on the World's threads. starts, ends: (N, 3) metres. Returns as query_batch().)");
    world.def("cast", &cast, "starts"_a, "ends"_a, "layer"_a = 1, "mask"_a = all, "group"_a = 0,
              R"(cast(self, starts, ends, layer=1, mask=4294967295, group=0)
--

Finds the first body that each segment hits, and where, on the World's threads. starts, ends: (N, 3) metres.

Returns a structured array (N,): body (uint64; 0: nothing is hit), verdict (uint8: COLLIDING; WITHIN where rounding
hides whether a round shape is touched; UNDECIDED if a file or a budget prevents the test), fraction_lower and
fraction_upper (float64: certified bounds of the fraction of the segment), point and normal (float64 (3,), world;
the normal faces the start, 0 where it is not defined), triangle (uint32), cell (int32 (4,)).)");
    world.def("cast_all", &cast_all, "start"_a, "end"_a, "layer"_a = 1, "mask"_a = all, "group"_a = 0,
              R"(cast_all(self, start, end, layer=1, mask=4294967295, group=0)
--

Finds the first point of a segment in each body that it hits, sorted along the segment. start, end: (3,) metres.
Returns as cast().)");
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
    world.def(
        "max_error",
        [](HeldWorld& held, py::handle a, py::handle b) {
            const char* const call = "World.max_error";
            const BodyId first = body(a, {call, "a"}), second = body(b, {call, "b"});
            const Looking looking(held, call);
            return held.world.pairs().max_error(first, second);
        },
        "a"_a, "b"_a, R"(max_error(self, a, b)
--

The error bound of `within` for these two bodies, metres above the clearance (float).)");
}

} // namespace oncollide::python
