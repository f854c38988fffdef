#include "study/truth.hpp"

#include <algorithm>
#include <cmath>

#include <oncollide/base/parallel.hpp>
#include <oncollide/narrowphase/relative_pose.hpp>
#include <oncollide/scenes/model/mesh_topology.hpp>

#include "differential/convex_truth.hpp"
#include "hard/solid_truth.hpp"
#include "hard/winding_number.hpp"
#include "study/accuracy_check.hpp"
#include "study/near_bodies.hpp"

namespace oncollide::tools {
namespace {

/// Of the bodies' size: what the exact level's distances may round by.
constexpr double distance_rounding = 0x1p-36;

const Geometry& geometry_of(const Scene& scene, std::uint32_t body)
{
    return scene.geometries[index(scene.geometry[body])];
}

/// Points that stand for all parts of a shape, a map or a terrain: each is on one side of a surface that it does not
/// meet.
std::vector<Eigen::Vector3d> points_of(const Geometry& geometry)
{
    std::vector<Eigen::Vector3d> points;
    if (const auto* map = std::get_if<OccupancyMap>(&geometry.data))
        map->each_box([&](const Aabb& cell) { points.push_back(cell.centre()); });
    else if (const auto* terrain = std::get_if<Terrain>(&geometry.data))
        for (const Mesh mesh = mesh_of(*terrain); const Triangle& t : mesh.triangles)
            points.push_back(mesh.vertices[t[0]]);
    else if (const auto* hull = std::get_if<ConvexHull>(&std::get<Shape>(geometry.data)))
        points.push_back(hull->points.front());
    else
        points.push_back(bounds_of(geometry).centre());
    return points;
}

} // namespace

/// What is kept of a mesh.
struct StudyTruth::Model {
    Model(const Mesh& mesh, Mode mode)
        : halved(mesh), at_home(halved, [](const Eigen::Vector3d& v) { return v; }),
          solid(mode == Mode::solid && is_closed(mesh)), parts(mode == Mode::solid ? parts_of(mesh) : decltype(parts)())
    {
    }

    HalvedMesh halved;
    BoxedTriangles at_home;
    bool solid;
    std::vector<std::uint32_t> parts; ///< by triangle; solid mode only

    bool winds_around(const BoxedTriangles& here, const Eigen::Vector3d& point) const
    {
        return solid && here.box().contains(point) &&
               std::abs(winding_number(here.points(), halved.mesh->triangles, point)) > 0.5L;
    }

    /// Is a part of `inner` inside? The surfaces do not meet.
    bool holds(const BoxedTriangles& here, const Model& inner, const BoxedTriangles& there) const
    {
        std::uint32_t next = 0;
        for (std::uint32_t i = 0; i < inner.parts.size(); ++i)
            if (inner.parts[i] == next && ++next && winds_around(here, there.triangle(i)[0])) return true;
        return false;
    }
};

StudyTruth::StudyTruth(const Scene& scene, const Settings& request)
    : scene_(scene), request_(request), models_(scene.geometries.size())
{
    for (GeometryId used : scene.geometry) {
        const auto* mesh = std::get_if<Mesh>(&scene.geometries[index(used)].data);
        if (mesh && !models_[index(used)]) models_[index(used)] = std::make_unique<Model>(*mesh, request.mode);
    }
}

StudyTruth::~StudyTruth() = default;

const StudyTruth::Model* StudyTruth::model(std::uint32_t body) const
{
    return models_[index(scene_.geometry[body])].get();
}

void StudyTruth::step()
{
    colliding_.clear(), open_.clear(), known_.clear();
    const std::vector<BodyPair> pairs = near_bodies(scene_, request_.clearance);
    std::vector<Decision> decisions(pairs.size());
    parallel_chunks(pairs.size(), 8, hardware_threads(), [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t k = begin; k < end; ++k)
            decisions[k] = model(pairs[k].a) && model(pairs[k].b) ? decide_meshes(pairs[k]) : decide_other(pairs[k]);
    });
    for (std::size_t k = 0; k < pairs.size(); ++k) {
        if (decisions[k] == Decision::collide) colliding_.push_back(pairs[k]);
        if (decisions[k] == Decision::open) open_.push_back(pairs[k]);
    }
}

StudyTruth::Decision StudyTruth::decide_meshes(BodyPair pair) const
{
    const Model &a = *model(pair.a), &b = *model(pair.b);
    const BoxedTriangles b_in_a(b.halved, RelativePose(scene_.poses[pair.a], scene_.poses[pair.b]));
    const TriangleContact least = request_.ignore_touching ? TriangleContact::crossing : TriangleContact::touching;
    const TriangleContact contact = contact_of(a.at_home, b_in_a, least);
    if (contact >= least) return Decision::collide;
    if (contact == TriangleContact::touching) { // ignored, unless insides overlap
        const SolidTruth solid = touching_truth_of(a.at_home, b_in_a);
        return solid.vague ? Decision::open : solid.contact == least ? Decision::collide : Decision::apart;
    }
    if (a.holds(a.at_home, b, b_in_a) || b.holds(b_in_a, a, a.at_home)) return Decision::collide;
    if (request_.clearance == 0) return Decision::apart;
    const DistanceTruth distance = mesh_distance(pair);
    const double rounding = distance_rounding * distance.size;
    if (distance.high <= request_.clearance - rounding) return Decision::collide;
    return distance.low <= request_.clearance + rounding ? Decision::open : Decision::apart;
}

StudyTruth::Decision StudyTruth::decide_other(BodyPair pair) const
{
    const DistanceTruth distance = convex_distance(pair);
    if (distance.high == 0 || holds_other(pair.a, pair.b) || holds_other(pair.b, pair.a)) return Decision::collide;
    if (distance.high < request_.clearance) return Decision::collide;
    return distance.low <= request_.clearance ? Decision::open : Decision::apart;
}

bool StudyTruth::holds_other(std::uint32_t outer, std::uint32_t inner) const
{
    const Model* around = model(outer);
    if (!around || !around->solid) return false;
    const RelativePose into(scene_.poses[outer], scene_.poses[inner]);
    return std::ranges::any_of(points_of(geometry_of(scene_, inner)), [&](const Eigen::Vector3d& p) {
        return around->winds_around(around->at_home, into(p));
    });
}

bool StudyTruth::collide(BodyPair pair) const
{
    return std::ranges::binary_search(colliding_, pair);
}

bool StudyTruth::open(BodyPair pair) const
{
    return std::ranges::binary_search(open_, pair);
}

DistanceTruth StudyTruth::mesh_distance(BodyPair pair) const
{
    return distance_of(model(pair.a)->halved, scene_.poses[pair.a], model(pair.b)->halved, scene_.poses[pair.b]);
}

/// Of shapes, cells and triangles, each a convex set. Extended precision errs by less than what is taken off.
DistanceTruth StudyTruth::convex_distance(BodyPair pair) const
{
    const auto sets = [&](std::uint32_t body) {
        return convex_sets(geometry_of(scene_, body).data, scene_.poses[body]);
    };
    const TrueDistance found = true_distance(sets(pair.a), sets(pair.b));
    DistanceTruth distance;
    distance.size =
        std::max(bounds_of(geometry_of(scene_, pair.a)).diagonal(), bounds_of(geometry_of(scene_, pair.b)).diagonal());
    const double rounding = distance_rounding * distance.size;
    distance.low = std::max(0.0, double(found.lower) - rounding);
    distance.high = found.upper > 0 ? double(found.upper) + rounding : 0;
    return distance;
}

DistanceTruth StudyTruth::distance(BodyPair pair)
{
    const auto [at, fresh] = known_.try_emplace(pair);
    if (!fresh) return at->second;
    DistanceTruth found;
    if (model(pair.a) && model(pair.b)) {
        found = mesh_distance(pair);
        found.low = std::max(0.0, found.low - distance_rounding * found.size);
    } else {
        found = convex_distance(pair);
    }
    return at->second = found;
}

} // namespace oncollide::tools
