#include "study/truth.hpp"

#include <algorithm>
#include <cmath>

#include <oncollide/base/parallel.hpp>
#include <oncollide/narrowphase/exact/relative_pose.hpp>
#include <oncollide/scenes/model/mesh_topology.hpp>

#include "differential/convex_truth.hpp"
#include "hard/solid_truth.hpp"
#include "hard/winding_number.hpp"
#include "study/accuracy_check.hpp"
#include "study/near_bodies.hpp"

namespace oncollide::tools {
namespace {

/// Largest rounding error of the exact level's distances, relative to the bodies' size.
constexpr double distance_rounding = 0x1p-36;

const Geometry& geometry_of(const Scene& scene, std::uint32_t body)
{
    return scene.geometries[index(scene.geometry[body])];
}

bool is_half_space(const Geometry& geometry)
{
    const auto* shape = std::get_if<Shape>(&geometry.data);
    return shape && std::holds_alternative<HalfSpace>(*shape);
}

/// `box` in another frame, grown to include all rounding.
Aabb moved(const Aabb& box, const Eigen::Isometry3d& pose)
{
    Aabb result;
    for (int k = 0; k < 8; ++k)
        result.add(pose * Eigen::Vector3d((k & 1 ? box.max : box.min).x(), (k & 2 ? box.max : box.min).y(),
                                          (k & 4 ? box.max : box.min).z()));
    return result;
}

Aabb grown(Aabb box, double by)
{
    box.min.array() -= by, box.max.array() += by;
    return box;
}

/// One point for each part of a shape or a map. If a part does not meet a surface, its point and the whole part are on
/// the same side.
std::vector<Eigen::Vector3d> points_of(const Geometry& geometry)
{
    std::vector<Eigen::Vector3d> points;
    if (const auto* map = std::get_if<OccupancyMap>(&geometry.data))
        map->each_box([&](const Aabb& cell) { points.push_back(cell.centre()); });
    else if (const auto* hull = std::get_if<ConvexHull>(&std::get<Shape>(geometry.data)))
        points.push_back(hull->points.front());
    else
        points.push_back(bounds_of(geometry).centre());
    return points;
}

} // namespace

/// Data of a mesh, or of a terrain as a mesh.
struct StudyTruth::Model {
    Model(std::shared_ptr<const Mesh> given, Mode mode) : Model(*given, mode) { kept = std::move(given); }
    Model(const Mesh& mesh, Mode mode)
        : halved(mesh), at_home(halved, [](const Eigen::Vector3d& v) { return v; }),
          solid(mode == Mode::solid && is_closed(mesh)), parts(mode == Mode::solid ? parts_of(mesh) : decltype(parts)())
    {
    }

    std::shared_ptr<const Mesh> kept; ///< null: the scene holds the mesh
    HalvedMesh halved;
    BoxedTriangles at_home;
    bool solid;
    std::vector<std::uint32_t> parts; ///< by triangle; only in solid mode

    bool winds_around(const BoxedTriangles& here, const Eigen::Vector3d& point) const
    {
        return solid && here.box().contains(point) &&
               std::abs(winding_number(here.points(), halved.mesh->triangles, point)) > 0.5L;
    }

    /// True if a part of `inner` is inside. Precondition: the surfaces do not meet.
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
        std::unique_ptr<Model>& model = models_[index(used)];
        const GeometryData& data = scene.geometries[index(used)].data;
        if (const auto* mesh = std::get_if<Mesh>(&data); mesh && !model)
            model = std::make_unique<Model>(*mesh, request.mode);
        if (const auto* terrain = std::get_if<Terrain>(&data); terrain && !model)
            model = std::make_unique<Model>(std::make_shared<const Mesh>(mesh_of(*terrain)), request.mode);
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

/// Distance of shapes, cells and triangles, each a convex set. The rounding subtracted exceeds the error of extended
/// precision.
DistanceTruth StudyTruth::convex_distance(BodyPair pair) const
{
    const Geometry &a = geometry_of(scene_, pair.a), &b = geometry_of(scene_, pair.b);
    const Eigen::Isometry3d at_a = scene_.poses[pair.a], at_b = scene_.poses[pair.b];
    DistanceTruth distance;
    for (const Geometry* g : {&a, &b})
        if (!is_half_space(*g)) distance.size = std::max(distance.size, bounds_of(*g).diagonal());
    TrueDistance found{};
    if (is_half_space(a) && is_half_space(b))
        found = half_spaces_distance(at_a, at_b);
    else if (is_half_space(a) || is_half_space(b))
        found = is_half_space(a) ? half_space_distance(at_a, convex_sets(b.data, at_b))
                                 : half_space_distance(at_b, convex_sets(a.data, at_a));
    else
        found = bounded_distance(pair);
    const double rounding = distance_rounding * distance.size;
    distance.low = std::max(0.0, double(found.lower) - rounding);
    distance.high = found.upper > 0 ? double(found.upper) + rounding : 0;
    return distance;
}

/// Tests parts near the other body first: a map may have millions.
TrueDistance StudyTruth::bounded_distance(BodyPair pair) const
{
    const auto sets = [&](std::uint32_t body, std::uint32_t other, double within) {
        const Aabb around = grown(
            moved(bounds_of(geometry_of(scene_, other)), scene_.poses[body].inverse() * scene_.poses[other]), within);
        return convex_sets(geometry_of(scene_, body).data, scene_.poses[body], &around);
    };
    double far = 0; // all parts are within this distance
    for (const std::uint32_t body : {pair.a, pair.b})
        far += 2 * (bounds_of(geometry_of(scene_, body)).diagonal() + scene_.poses[body].translation().norm() +
                    bounds_of(geometry_of(scene_, body)).centre().norm());
    for (double within = 0x1p-10 * far + request_.clearance;; within *= 4) {
        const std::vector<ConvexSet> a = sets(pair.a, pair.b, within), b = sets(pair.b, pair.a, within);
        if (!a.empty() && !b.empty())
            if (const TrueDistance found = true_distance(a, b); found.upper <= 0.99 * within || within > far)
                return found;
    }
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
