#include "fcl/fcl_world.hpp"

#include <algorithm>
#include <chrono>

#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>

#include "fcl/fcl_pair.hpp"

namespace oncollide::tools {
namespace {

using Clock = std::chrono::steady_clock;

double lap(Clock::time_point& from)
{
    const Clock::time_point now = Clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - from).count();
    from = now;
    return ms;
}

/// Bounds a half-space: FCL's trees abort the program on unbounded boxes.
void bound_half_space(fcl::CollisionGeometryd& geometry)
{
    if (geometry.getNodeType() != fcl::GEOM_HALFSPACE) return;
    const fcl::Vector3d end = fcl::Vector3d::Constant(half_space_end);
    geometry.aabb_local = fcl::AABBd(fcl::Vector3d(-end), end);
    geometry.aabb_center.setZero(), geometry.aabb_radius = end.norm();
}

} // namespace

struct FclWorld::Impl {
    explicit Impl(const Scene& s) : scene(s) {}

    const Scene& scene;
    std::vector<FclGeometry> models, distance_models; ///< by geometry; distance_models made on first use
    std::vector<std::unique_ptr<fcl::CollisionObjectd>> objects;
    std::vector<std::uint32_t> moving;
    fcl::DynamicAABBTreeCollisionManagerd moving_tree, static_tree;
    std::vector<BodyPair> candidates, colliding;

    static bool take(fcl::CollisionObjectd* x, fcl::CollisionObjectd* y, void* data)
    {
        Impl& me = *static_cast<Impl*>(data);
        const auto number = [](const fcl::CollisionObjectd* object) {
            return static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(object->getUserData()));
        };
        const std::uint32_t a = std::min(number(x), number(y)), b = std::max(number(x), number(y));
        if ((me.scene.layers[a] & me.scene.masks[b]) && (me.scene.layers[b] & me.scene.masks[a]))
            me.candidates.push_back({a, b});
        return false; // continue
    }

    FclBody body_for_distance(std::uint32_t b)
    {
        const std::uint32_t geometry = index(scene.geometry[b]);
        FclGeometry& model = distance_models[geometry];
        if (std::holds_alternative<OccupancyMap>(scene.geometries[geometry].data)) return body(b);
        if (!model) model = make_fcl_geometry(scene.geometries[geometry].data, FclNodes::obbrss);
        return {model, scene.poses[b]};
    }
    FclBody body(std::uint32_t b) const { return {models[index(scene.geometry[b])], scene.poses[b]}; }
};

FclWorld::Octrees FclWorld::octrees_of(const Scene& scene)
{
    Octrees octrees;
    for (const Geometry& geometry : scene.geometries) {
        const auto* map = std::get_if<OccupancyMap>(&geometry.data);
        octrees.push_back(map ? make_octree(*map) : nullptr);
    }
    return octrees;
}

FclWorld::FclWorld(const Scene& scene, const Octrees& octrees) : impl_(std::make_unique<Impl>(scene))
{
    Impl& w = *impl_;
    for (std::size_t i = 0; i < scene.geometries.size(); ++i)
        w.models.push_back(make_fcl_geometry(scene.geometries[i].data, FclNodes::obb, octrees[i]));
    w.distance_models.resize(scene.geometries.size());
    std::vector<fcl::CollisionObjectd*> moving, fixed;
    for (std::uint32_t body = 0; body < scene.size(); ++body) {
        const fcl::Transform3d pose = scene.poses[body];
        w.objects.push_back(std::make_unique<fcl::CollisionObjectd>(w.models[index(scene.geometry[body])], pose));
        bound_half_space(*w.models[index(scene.geometry[body])]); // objects compute AABBs from their geometry
        w.objects.back()->computeAABB();
        w.objects.back()->setUserData(reinterpret_cast<void*>(std::uintptr_t{body}));
        (scene.is_static[body] ? fixed : moving).push_back(w.objects.back().get());
        if (!scene.is_static[body]) w.moving.push_back(body);
    }
    if (!moving.empty()) w.moving_tree.registerObjects(moving);
    if (!fixed.empty()) w.static_tree.registerObjects(fixed);
    w.moving_tree.setup(), w.static_tree.setup();
}

FclWorld::~FclWorld() = default;

FclFrame FclWorld::step(bool contacts)
{
    Impl& w = *impl_;
    FclFrame frame;
    Clock::time_point from = Clock::now();
    for (std::uint32_t body : w.moving) {
        w.objects[body]->setTransform(w.scene.poses[body]);
        w.objects[body]->computeAABB();
    }
    frame.transforms_ms = lap(from);
    if (!w.moving.empty()) w.moving_tree.update();
    frame.update_ms = lap(from);
    w.candidates.clear();
    if (!w.moving.empty()) w.moving_tree.collide(&w, &Impl::take);
    if (!w.moving.empty() && !w.static_tree.empty()) w.moving_tree.collide(&w.static_tree, &w, &Impl::take);
    frame.pairs_ms = lap(from);
    w.colliding.clear();
    for (BodyPair pair : w.candidates) {
        const std::size_t found = fcl_contacts(w.body(pair.a), w.body(pair.b), contacts ? 1'000'000 : 1, contacts);
        if (found) w.colliding.push_back(pair);
        if (contacts) frame.contacts += found;
    }
    std::sort(w.colliding.begin(), w.colliding.end());
    frame.narrow_ms = lap(from);
    frame.candidates = w.candidates.size(), frame.colliding = w.colliding;
    return frame;
}

double FclWorld::distance(BodyPair pair)
{
    // FCL's distance between meshes does not see one deep inside the other's surface.
    if (fcl_contacts(impl_->body(pair.a), impl_->body(pair.b))) return 0;
    return fcl_distance(impl_->body_for_distance(pair.a), impl_->body_for_distance(pair.b));
}

FclWorld::ModelBytes FclWorld::model_bytes() const
{
    ModelBytes sum;
    for (const FclGeometry& model : impl_->models) {
        sum.obb += fcl_mesh_bytes(model, FclNodes::obb);
        sum.obbrss += fcl_mesh_bytes(model, FclNodes::obbrss);
    }
    return sum;
}

} // namespace oncollide::tools
