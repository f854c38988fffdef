#include "peers/fcl_world.hpp"

#include <algorithm>
#include <chrono>

#include <fcl/fcl.h>

#include <oncollide/scenes/model/convex_hull.hpp>

namespace oncollide::tools {
namespace {

using ModelPtr = std::shared_ptr<fcl::CollisionGeometryd>;
using Clock = std::chrono::steady_clock;

double milliseconds_since(Clock::time_point& from)
{
    const Clock::time_point now = Clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - from).count();
    from = now;
    return ms;
}

template <class Volume>
ModelPtr make_bvh(const Mesh& mesh)
{
    auto model = std::make_shared<fcl::BVHModel<Volume>>();
    std::vector<fcl::Triangle> triangles;
    triangles.reserve(mesh.triangles.size());
    for (const Triangle& t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
    model->beginModel(static_cast<int>(triangles.size()), static_cast<int>(mesh.vertices.size()));
    model->addSubModel(mesh.vertices, triangles);
    model->endModel();
    return model;
}

ModelPtr make_convex(const ConvexHull& shape)
{
    const Hull hull = convex_hull(shape.points);
    std::vector<int> place(shape.points.size(), -1);
    auto points = std::make_shared<std::vector<fcl::Vector3d>>();
    for (std::uint32_t v : hull.vertices) {
        place[v] = static_cast<int>(points->size());
        points->push_back(shape.points[v]);
    }
    auto faces = std::make_shared<std::vector<int>>();
    for (const Triangle& t : hull.triangles) faces->insert(faces->end(), {3, place[t[0]], place[t[1]], place[t[2]]});
    return std::make_shared<fcl::Convexd>(points, static_cast<int>(hull.triangles.size()), faces);
}

struct ShapeModel {
    ModelPtr operator()(const Sphere& s) const { return std::make_shared<fcl::Sphered>(s.radius); }
    ModelPtr operator()(const Box& b) const { return std::make_shared<fcl::Boxd>(fcl::Vector3d(2 * b.half)); }
    ModelPtr operator()(const Capsule& c) const { return std::make_shared<fcl::Capsuled>(c.radius, c.length); }
    ModelPtr operator()(const Cylinder& c) const { return std::make_shared<fcl::Cylinderd>(c.radius, c.length); }
    ModelPtr operator()(const ConvexHull& h) const { return make_convex(h); }
};

template <class Volume>
ModelPtr make_model(const Geometry& geometry)
{
    ModelPtr model;
    if (const auto* mesh = std::get_if<Mesh>(&geometry.data))
        model = make_bvh<Volume>(*mesh);
    else if (const auto* shape = std::get_if<Shape>(&geometry.data))
        model = std::visit(ShapeModel{}, *shape);
    else
        model = std::make_shared<fcl::OcTreed>(std::get<OccupancyMap>(geometry.data).tree);
    model->computeLocalAABB();
    return model;
}

} // namespace

struct FclWorld::Impl {
    explicit Impl(const Scene& s) : scene(s) {}

    const Scene& scene;
    std::vector<ModelPtr> models, distance_models; ///< by geometry; the second when first needed
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
        return false; // go on
    }

    bool collide(BodyPair pair) const
    {
        const fcl::CollisionRequestd request(1, false);
        fcl::CollisionResultd result;
        return fcl::collide(objects[pair.a].get(), objects[pair.b].get(), request, result) > 0;
    }

    std::size_t contacts(BodyPair pair) const
    {
        const fcl::CollisionRequestd request(1'000'000, true);
        fcl::CollisionResultd result;
        fcl::collide(objects[pair.a].get(), objects[pair.b].get(), request, result);
        return result.numContacts();
    }

    const fcl::CollisionGeometryd* distance_model(std::uint32_t body)
    {
        const std::uint32_t geometry = index(scene.geometry[body]);
        ModelPtr& model = distance_models[geometry];
        if (!model) model = make_model<fcl::OBBRSSd>(scene.geometries[geometry]);
        return model.get();
    }
};

FclWorld::FclWorld(const Scene& scene) : impl_(std::make_unique<Impl>(scene))
{
    Impl& w = *impl_;
    for (const Geometry& geometry : scene.geometries) w.models.push_back(make_model<fcl::OBBd>(geometry));
    w.distance_models.resize(scene.geometries.size());
    std::vector<fcl::CollisionObjectd*> moving, fixed;
    for (std::uint32_t body = 0; body < scene.size(); ++body) {
        const fcl::Transform3d pose = scene.poses[body];
        w.objects.push_back(std::make_unique<fcl::CollisionObjectd>(w.models[index(scene.geometry[body])], pose));
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
    frame.transforms_ms = milliseconds_since(from);
    if (!w.moving.empty()) w.moving_tree.update();
    frame.update_ms = milliseconds_since(from);
    w.candidates.clear();
    if (!w.moving.empty()) w.moving_tree.collide(&w, &Impl::take);
    if (!w.moving.empty() && !w.static_tree.empty()) w.moving_tree.collide(&w.static_tree, &w, &Impl::take);
    frame.pairs_ms = milliseconds_since(from);
    w.colliding.clear();
    for (BodyPair pair : w.candidates) {
        const std::size_t found = contacts ? w.contacts(pair) : w.collide(pair);
        if (found) w.colliding.push_back(pair);
        if (contacts) frame.contacts += found;
    }
    std::sort(w.colliding.begin(), w.colliding.end());
    frame.narrow_ms = milliseconds_since(from);
    frame.candidates = w.candidates.size(), frame.colliding = w.colliding;
    return frame;
}

bool FclWorld::collides(BodyPair pair) const
{
    const Impl& w = *impl_;
    const auto model = [&](std::uint32_t body) { return w.models[index(w.scene.geometry[body])].get(); };
    const fcl::CollisionRequestd request(1, false);
    fcl::CollisionResultd result;
    return fcl::collide(model(pair.a), w.scene.poses[pair.a], model(pair.b), w.scene.poses[pair.b], request, result) >
           0;
}

double FclWorld::distance(BodyPair pair)
{
    Impl& w = *impl_;
    if (collides(pair)) return 0; // distance() between meshes does not see one deep inside the other's surface
    const fcl::DistanceRequestd request;
    fcl::DistanceResultd result;
    const double distance = fcl::distance(w.distance_model(pair.a), w.scene.poses[pair.a], w.distance_model(pair.b),
                                          w.scene.poses[pair.b], request, result);
    return std::max(distance, 0.0);
}

double FclWorld::penetration(BodyPair pair) const
{
    const Impl& w = *impl_;
    const fcl::CollisionRequestd request(10'000, true);
    fcl::CollisionResultd result;
    fcl::collide(w.objects[pair.a].get(), w.objects[pair.b].get(), request, result);
    double deepest = 0;
    for (std::size_t i = 0; i < result.numContacts(); ++i)
        deepest = std::max(deepest, std::abs(result.getContact(i).penetration_depth));
    return deepest;
}

bool FclWorld::has_shape(BodyPair pair) const
{
    const auto shape = [&](std::uint32_t body) {
        return std::holds_alternative<Shape>(impl_->scene.geometries[index(impl_->scene.geometry[body])].data);
    };
    return shape(pair.a) || shape(pair.b);
}

FclWorld::ModelBytes FclWorld::model_bytes() const
{
    using Model = fcl::BVHModel<fcl::OBBd>; // its memUsage() returns a status, not a size
    ModelBytes sum;
    for (const ModelPtr& model : impl_->models)
        if (const auto* mesh = dynamic_cast<const Model*>(model.get())) {
            const auto nodes = static_cast<std::size_t>(mesh->getNumBVs());
            const std::size_t rest = static_cast<std::size_t>(mesh->num_tris) * (sizeof(fcl::Triangle) + sizeof(int)) +
                                     static_cast<std::size_t>(mesh->num_vertices) * sizeof(fcl::Vector3d);
            sum.obb += nodes * sizeof(fcl::BVNode<fcl::OBBd>) + rest;
            sum.obbrss += nodes * sizeof(fcl::BVNode<fcl::OBBRSSd>) + rest;
        }
    return sum;
}

} // namespace oncollide::tools
