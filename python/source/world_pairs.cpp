// Queries of a World about pairs: decide, distance, contacts, penetration.
#include <cstring>

#include <fmt/format.h>

#include "held_world.hpp"

namespace oncollide::python {

namespace {

/// One side of a pair: the id of a body, or a model at a pose as a tuple (model, pose).
class Side {
public:
    Side(const HeldWorld& held, py::handle value, const Place& place)
    {
        if (!py::isinstance<py::tuple>(value)) {
            body_ = body(value, place);
            return;
        }
        const auto pair = py::reinterpret_borrow<py::tuple>(value);
        if (pair.size() != 2) refuse_value(place, "expected the id of a body, or a tuple (model, pose)");
        placed_ = PlacedModel{model_of(held, pair[0], place), pose(pair[1], place)};
    }
    operator PairSide() const { return placed_ ? PairSide(*placed_) : PairSide(body_); }

private:
    BodyId body_;
    std::optional<PlacedModel> placed_;
};

std::vector<PairOfBodies> pairs_of(py::handle a, py::handle b, const char* call)
{
    const std::vector<BodyId> firsts = bodies(a, {call, "a"}), seconds = bodies(b, {call, "b"});
    if (firsts.size() != seconds.size())
        refuse_value({call, "b"}, fmt::format("{} bodies for {} of a; must be as many", seconds.size(), firsts.size()));
    std::vector<PairOfBodies> pairs;
    for (std::size_t i = 0; i < firsts.size(); ++i) pairs.push_back({firsts[i], seconds[i]});
    return pairs;
}

/// A structured scalar with the bytes of `found`.
template <class Found>
py::object scalar(const ResultType& type, const Found& found)
{
    py::array made(type.type, py::ssize_t{1});
    std::memcpy(made.mutable_data(), static_cast<const void*>(&found), sizeof found);
    type.clear_gaps(made.mutable_data(), 1);
    return made[py::int_(0)];
}

/// Returns query(world); other Python threads run meanwhile.
template <class Query>
auto released(HeldWorld& held, const char* call, Query query)
{
    const Looking looking(held, call);
    const Released released;
    return query(held.world);
}

double limit(py::handle cutoff, py::handle farthest, const char* call)
{
    return farthest.is_none() ? limit_of(cutoff, {call, "cutoff"}) : limit_of(farthest, {call, "farthest"});
}

py::object decide(HeldWorld& held, py::handle a, py::handle b)
{
    const char* const call = "World.decide";
    const Side first(held, a, {call, "a"}), second(held, b, {call, "b"});
    return scalar(result_types().finding,
                  released(held, call, [&](const World& w) { return w.decide(first, second); }));
}

py::array decide_batch(HeldWorld& held, py::handle a, py::handle b)
{
    const char* const call = "World.decide_batch";
    const std::vector<PairOfBodies> pairs = pairs_of(a, b, call);
    return array_of(result_types().finding, released(held, call, [&](const World& w) {
                        std::vector<Finding> found(pairs.size());
                        w.decide(pairs, found);
                        return found;
                    }));
}

py::object distance(HeldWorld& held, py::handle a, py::handle b, py::handle tolerance, py::handle cutoff,
                    py::handle farthest)
{
    const char* const call = "World.distance";
    const Side first(held, a, {call, "a"}), second(held, b, {call, "b"});
    const double within = number(tolerance, {call, "tolerance"}), most = limit(cutoff, farthest, call);
    return scalar(result_types().distance,
                  released(held, call, [&](const World& w) { return w.distance(first, second, within, most); }));
}

py::array distance_batch(HeldWorld& held, py::handle a, py::handle b, py::handle tolerance, py::handle cutoff)
{
    const char* const call = "World.distance_batch";
    const std::vector<PairOfBodies> pairs = pairs_of(a, b, call);
    const double within = number(tolerance, {call, "tolerance"}), most = limit_of(cutoff, {call, "cutoff"});
    return array_of(result_types().distance, released(held, call, [&](const World& w) {
                        std::vector<Distance> found(pairs.size());
                        w.distances(pairs, found, within, most);
                        return found;
                    }));
}

py::tuple distances(HeldWorld& held, py::handle model, py::handle at, py::handle cutoff, py::handle tolerance,
                    py::handle layer, py::handle mask, py::handle group)
{
    const char* const call = "World.distances";
    const PlacedModel query{model_of(held, model, {call, "model"}),
                            pose(at, {call, "pose"}),
                            {bits(layer, {call, "layer"}), bits(mask, {call, "mask"}), bits(group, {call, "group"})}};
    const double within = number(tolerance, {call, "tolerance"}), most = number(cutoff, {call, "cutoff"});
    const std::vector<BodyDistance> found =
        released(held, call, [&](const World& w) { return w.distances(query, most, within); });
    std::vector<BodyId> ids;
    std::vector<Distance> far;
    for (const BodyDistance& one : found) ids.push_back(one.body), far.push_back(one.distance);
    return py::make_tuple(ids_of(ids), array_of(result_types().distance, std::move(far)));
}

py::array contacts(HeldWorld& held, py::handle a, py::handle b)
{
    const char* const call = "World.contacts";
    const Side first(held, a, {call, "a"}), second(held, b, {call, "b"});
    return array_of(result_types().contact,
                    released(held, call, [&](const World& w) { return w.contacts(first, second); }));
}

py::tuple contacts_batch(HeldWorld& held, py::handle a, py::handle b)
{
    const char* const call = "World.contacts_batch";
    const std::vector<PairOfBodies> pairs = pairs_of(a, b, call);
    Lists<Contact> lists;
    released(held, call, [&](const World& w) { return w.contacts(pairs, lists), 0; });
    return py::make_tuple(array_of(result_types().contact, std::move(lists.contacts)), offsets_of(lists.offsets));
}

py::object penetration(HeldWorld& held, py::handle a, py::handle b)
{
    const char* const call = "World.penetration";
    const Side first(held, a, {call, "a"}), second(held, b, {call, "b"});
    return scalar(result_types().penetration,
                  released(held, call, [&](const World& w) { return w.penetration(first, second); }));
}

py::array penetration_batch(HeldWorld& held, py::handle a, py::handle b)
{
    const char* const call = "World.penetration_batch";
    const std::vector<PairOfBodies> pairs = pairs_of(a, b, call);
    return array_of(result_types().penetration, released(held, call, [&](const World& w) {
                        std::vector<Penetration> found(pairs.size());
                        w.penetration(pairs, found);
                        return found;
                    }));
}

ManifoldOptions options_of(double margin, double normal_spread, std::uint32_t points_per_region,
                           std::uint32_t regions_per_pair, std::uint32_t points_per_pair)
{
    return {margin, normal_spread, points_per_region, regions_per_pair, points_per_pair};
}

py::tuple manifold(HeldWorld& held, py::handle a, py::handle b, double margin, double normal_spread,
                   std::uint32_t points_per_region, std::uint32_t regions_per_pair, std::uint32_t points_per_pair)
{
    const char* const call = "World.manifold";
    const Side first(held, a, {call, "a"}), second(held, b, {call, "b"});
    const ManifoldOptions options =
        options_of(margin, normal_spread, points_per_region, regions_per_pair, points_per_pair);
    Manifold found = released(held, call, [&](const World& w) { return w.manifold(first, second, options); });
    return py::make_tuple(array_of(result_types().region, std::move(found.regions)),
                          array_of(result_types().manifold_point, std::move(found.points)), found.complete);
}

py::tuple manifolds(HeldWorld& held, py::handle a, py::handle b, double margin, double normal_spread,
                    std::uint32_t points_per_region, std::uint32_t regions_per_pair, std::uint32_t points_per_pair,
                    std::uint32_t points_in_all)
{
    const char* const call = "World.manifolds";
    const std::vector<PairOfBodies> pairs = pairs_of(a, b, call);
    ManifoldOptions options = options_of(margin, normal_spread, points_per_region, regions_per_pair, points_per_pair);
    options.points_in_all = points_in_all;
    ManifoldLists lists;
    released(held, call, [&](const World& w) { return w.manifolds(pairs, options, lists), 0; });
    return py::make_tuple(array_of(result_types().region, std::move(lists.regions)),
                          array_of(result_types().manifold_point, std::move(lists.points)), offsets_of(lists.offsets),
                          array_of(py::dtype("?"), std::move(lists.complete)));
}

py::tuple near_features(HeldWorld& held, py::handle a, py::handle b, double dhat)
{
    const char* const call = "World.near_features";
    const std::vector<PairOfBodies> pairs = pairs_of(a, b, call);
    Lists<NearFeatures> lists;
    released(held, call, [&](const World& w) { return w.near_features(pairs, dhat, lists), 0; });
    return py::make_tuple(array_of(result_types().near_features, std::move(lists.features)), offsets_of(lists.offsets));
}

void bind_world_manifolds(WorldClass& world)
{
    using namespace py::literals;
    const double spread = ManifoldOptions{}.normal_spread;
    world.def(
        "manifold", &manifold, "a"_a, "b"_a, "margin"_a = 0.0, "normal_spread"_a = spread, "points_per_region"_a = 4,
        "regions_per_pair"_a = 16, "points_per_pair"_a = 64,
        R"(manifold(self, a, b, margin=0.0, normal_spread=0.174532925199433, points_per_region=4, regions_per_pair=16, points_per_pair=64)
--

Reduces the contacts for a solver. a, b: as in decide(), of any kind.

margin: metres; parts of surfaces this near are regions, too. normal_spread: radians; faces of one region differ by at
most twice this. points_per_region, regions_per_pair, points_per_pair: at least 1; regions share the points of a pair in
turn, the deepest first.
Returns (regions, points, complete). regions: a structured array, the deepest first: kind (uint8: 0 crossing, 1 touching,
2 enclosed, 3 near), open (bool: a surface is not closed), normal (float64 (3,), unit, from a to b), normal_error
(radians; pi where no normal has a meaning), area, volume, centre (3,), depth_lower, depth_upper (certified), lost (no
exact contact is farther than this from the hull of the points), first, count (its points), found (candidates before the
reduction). points: point_a, point_b (float64 (3,)), depth (> 0 inside), depth_error, feature_a, feature_b (uint64), normal
(3,) (unit: across the faces at the point, or the region's).
complete: False if a limit left out a region or a point, or the pair has no manifold. World frame, metres.)");
    world.def(
        "manifolds", &manifolds, "a"_a, "b"_a, "margin"_a = 0.0, "normal_spread"_a = spread, "points_per_region"_a = 4,
        "regions_per_pair"_a = 16, "points_per_pair"_a = 64, "points_in_all"_a = 0,
        R"(manifolds(self, a, b, margin=0.0, normal_spread=0.174532925199433, points_per_region=4, regions_per_pair=16, points_per_pair=64, points_in_all=0)
--

The same for many pairs, on the World's threads. a, b: (N,) ids. points_in_all: limit of the points of all pairs, which
share them in turn, the deepest first; 0: no limit.

Returns (regions, points, offsets, complete): pair i has regions[offsets[i]:offsets[i + 1]]; complete is bool (N,).)");
    world.def("near_features", &near_features, "a"_a, "b"_a, "dhat"_a, R"(near_features(self, a, b, dhat)
--

All pairs of a vertex and a face, or of two edges, at most `dhat` metres apart, of many pairs of bodies with triangles.
a, b: (N,) ids.

Returns (features, offsets): pair i has features[offsets[i]:offsets[i + 1]], a structured array: a, b (uint64 features,
as in manifold()), lower, upper (float64, certified bounds of the distance), point_a, point_b (float64 (3,)).)");
}

} // namespace

void bind_world_pairs(WorldClass& world)
{
    bind_world_manifolds(world);
    using namespace py::literals;
    const auto none = py::none();
    const py::int_ all(0xffffffffu);
    world.def("decide", &decide, "a"_a, "b"_a, R"(decide(self, a, b)
--

The verdict on one pair now, as step() would give it. Layers, groups and exclusions do not matter.

a, b: each the id of a body, or a tuple (model, pose) for a model at a pose.
Returns a structured scalar: verdict (uint8, a Verdict), kind (uint8, a ContactKind), bound (float64, metres).)");
    world.def("decide_batch", &decide_batch, "a"_a, "b"_a, R"(decide_batch(self, a, b)
--

The verdicts on many pairs now, on the World's threads. a, b: (N,) ids. Returns a structured array (N,) as decide().)");
    world.def("distance", &distance, "a"_a, "b"_a, "tolerance"_a = 0.0, "cutoff"_a = none, "farthest"_a = none,
              R"(distance(self, a, b, tolerance=0.0, cutoff=None, farthest=None)
--

Certified bounds on the distance of two sides of a pair, and their nearest points.

a, b: as in decide(). tolerance: metres, >= 0; a larger tolerance is cheaper. cutoff: metres; beyond it lower > cutoff and
upper = inf; None: no cutoff. farthest: the older name of cutoff.
Returns a structured scalar: lower, upper (float64, metres; both 0 if they meet), triangle_a, cell_a, triangle_b, cell_b
(as in contacts()), point_a, point_b (float64 (3,), world frame, if upper is finite).)");
    world.def("distance_batch", &distance_batch, "a"_a, "b"_a, "tolerance"_a = 0.0, "cutoff"_a = none,
              R"(distance_batch(self, a, b, tolerance=0.0, cutoff=None)
--

The distances of many pairs, on the World's threads. a, b: (N,) ids. Returns a structured array (N,) as distance().)");
    world.def("distances", &distances, "model"_a, "pose"_a, "cutoff"_a, "tolerance"_a = 0.0, "layer"_a = 1,
              "mask"_a = all, "group"_a = 0,
              R"(distances(self, model, pose, cutoff, tolerance=0.0, layer=1, mask=4294967295, group=0)
--

The bodies at most `cutoff` metres from a model at a pose, and their distances.

Returns (bodies, distances): uint64 (N,), sorted by slot, and a structured array (N,) as distance().)");
    world.def("contacts", &contacts, "a"_a, "b"_a, R"(contacts(self, a, b)
--

All pairs of parts of the two sides of a pair that meet. a, b: as in decide().

Returns a structured array (N,): triangle_a, triangle_b (uint32, indices of triangles; 0 for other parts), cell_a,
cell_b (int32 (4,): for maps the cube's x, y, z and side, in cells), kind (uint8, a ContactKind), ends (float64 (2, 3):
for two triangles the segment that both share, else a point on each part), normal_a, normal_b (float64 (3,), unit).
World frame, metres.)");
    world.def("contacts_batch", &contacts_batch, "a"_a, "b"_a, R"(contacts_batch(self, a, b)
--

The same for many pairs, on the World's threads. a, b: (N,) ids. points_in_all: limit of the points of all pairs, which
share them in turn, the deepest first; 0: no limit.

Returns (contacts, offsets): pair i has contacts[offsets[i]:offsets[i + 1]]; offsets is int64 (N + 1,).)");
    world.def("penetration", &penetration, "a"_a, "b"_a, R"(penetration(self, a, b)
--

How deep the two sides of a pair penetrate each other: how far the deepest point of one lies inside the other, from its
surface. a, b: as in decide(), of any kind. A terrain is solid below its surface.

Returns a structured scalar: supported (bool: False for two terrains and for cooked meshes read on demand), depth and
depth_upper (float64, metres: certified bounds; both 0 where the two are apart), deepest (float64 (3,), a point that is
depth deep), of_a (bool, it is a point of a). For two
sides with triangles (meshes, boxes, hulls) depth is the depth of a vertex, and these are set: contact, overlap (float64 (2, 3): corners of a box around the contact curve, and around the
overlap), vertex (uint32, the index of the deepest), thickness (float64, metres: the overlap lies between two planes
this far apart), thin_along (float64 (3,), unit normal of these planes).)");
    world.def("penetration_batch", &penetration_batch, "a"_a, "b"_a, R"(penetration_batch(self, a, b)
--

The same for many pairs, on the World's threads. a, b: (N,) ids. Returns a structured array (N,) as penetration().)");
}

} // namespace oncollide::python
