#include <oncollide/narrowphase/exact/exact_fcl.hpp>

#include <fcl/fcl.h>
#include <fcl/narrowphase/detail/traversal/collision/intersect.h>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/model/convex_hull.hpp>

namespace oncollide {

namespace {

using ModelPtr = std::shared_ptr<fcl::CollisionGeometryd>;

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

struct ShapeModel {
    ModelPtr operator()(const Sphere& s) const { return std::make_shared<fcl::Sphered>(s.radius); }
    ModelPtr operator()(const Box& b) const { return std::make_shared<fcl::Boxd>(fcl::Vector3d(2 * b.half)); }
    ModelPtr operator()(const Capsule& c) const { return std::make_shared<fcl::Capsuled>(c.radius, c.length); }
    ModelPtr operator()(const Cylinder& c) const { return std::make_shared<fcl::Cylinderd>(c.radius, c.length); }
    ModelPtr operator()(const ConvexHull& h) const
    {
        const Hull hull = convex_hull(h.points);
        std::vector<int> place(h.points.size(), -1);
        auto points = std::make_shared<std::vector<fcl::Vector3d>>();
        for (std::uint32_t v : hull.vertices) {
            place[v] = static_cast<int>(points->size());
            points->push_back(h.points[v]);
        }
        auto faces = std::make_shared<std::vector<int>>();
        for (const Triangle& t : hull.triangles) {
            faces->push_back(3);
            for (std::uint32_t v : t) faces->push_back(place[v]);
        }
        return std::make_shared<fcl::Convexd>(points, static_cast<int>(hull.triangles.size()), faces);
    }
};

const Mesh* mesh_of(const Scene& scene, std::uint32_t body)
{
    return std::get_if<Mesh>(&scene.geometries[index(scene.geometry[body])].data);
}

} // namespace

bool fcl_available()
{
    return true;
}

struct ExactFcl::Impl {
    const Scene* scene;
    double clearance;
    std::vector<ModelPtr> models; ///< by geometry; null until needed
};

ExactFcl::ExactFcl(const Scene& scene, double clearance)
    : impl_(std::make_unique<Impl>(Impl{&scene, clearance, std::vector<ModelPtr>(scene.geometries.size())}))
{
}
ExactFcl::~ExactFcl() = default;

void ExactFcl::prepare(GeometryId geometry)
{
    ModelPtr& model = impl_->models[index(geometry)];
    if (model) return;
    const auto& data = impl_->scene->geometries[index(geometry)].data;
    // OBBs alone answer faster; distances need the swept spheres of OBBRSS.
    if (const auto* mesh = std::get_if<Mesh>(&data))
        model = impl_->clearance > 0 ? make_bvh<fcl::OBBRSSd>(*mesh) : make_bvh<fcl::OBBd>(*mesh);
    else if (const auto* shape = std::get_if<Shape>(&data))
        model = std::visit(ShapeModel{}, *shape);
    else
        model = std::make_shared<fcl::OcTreed>(std::get<OccupancyMap>(data).tree);
    model->computeLocalAABB();
}

ExactFcl::Answer ExactFcl::answer(const Scene& scene, std::uint32_t a, std::uint32_t b) const
{
    const ModelPtr &model_a = impl_->models[index(scene.geometry[a])],
                   &model_b = impl_->models[index(scene.geometry[b])];
    ONCOLLIDE_ASSERT(model_a && model_b);
    fcl::CollisionRequestd request(1, false);
    fcl::CollisionResultd result;
    fcl::collide(model_a.get(), scene.poses[a], model_b.get(), scene.poses[b], request, result);
    if (result.isCollision()) {
        if (!both_meshes(scene, a, b)) return {Verdict::colliding, 0};
        return {Verdict::colliding, 0, static_cast<int>(result.getContact(0).b1),
                static_cast<int>(result.getContact(0).b2)};
    }
    if (impl_->clearance <= 0) return {Verdict::separate, 0};
    fcl::DistanceRequestd distance_request;
    fcl::DistanceResultd distance_result;
    // At the origin: FCL measures in world coordinates, which round where bodies are far away.
    Eigen::Isometry3d pose_a = scene.poses[a], pose_b = scene.poses[b];
    pose_b.translation() -= pose_a.translation(), pose_a.translation().setZero();
    const double distance =
        fcl::distance(model_a.get(), pose_a, model_b.get(), pose_b, distance_request, distance_result);
    return {distance <= impl_->clearance ? Verdict::within : Verdict::separate, std::max(distance, 0.0)};
}

bool ExactFcl::both_meshes(const Scene& scene, std::uint32_t a, std::uint32_t b) const
{
    return mesh_of(scene, a) && mesh_of(scene, b);
}

bool ExactFcl::triangles_meet(const Scene& scene, std::uint32_t a, std::uint32_t b, std::span<const std::uint32_t> of_a,
                              std::span<const std::uint32_t> of_b, std::vector<Aabb>& scratch) const
{
    const Mesh *mesh_a = mesh_of(scene, a), *mesh_b = mesh_of(scene, b);
    ONCOLLIDE_ASSERT(mesh_a && mesh_b);
    // As FCL's own traversal does: b's triangles in a's frame.
    const fcl::Matrix3d r = scene.poses[a].linear().transpose() * scene.poses[b].linear();
    const fcl::Vector3d t =
        scene.poses[a].linear().transpose() * (scene.poses[b].translation() - scene.poses[a].translation());
    const auto box_of = [](const Mesh& mesh, std::uint32_t triangle, auto&& place) {
        Aabb box;
        for (std::uint32_t v : mesh.triangles[triangle]) box.add(fcl::Vector3d(place(mesh.vertices[v])));
        return box;
    };
    scratch.clear();
    Aabb all_b;
    for (std::uint32_t i : of_b) {
        scratch.push_back(box_of(*mesh_b, i, [&](const fcl::Vector3d& v) { return r * v + t; }));
        all_b.add(scratch.back());
    }
    for (std::uint32_t i : of_a) {
        const Aabb box = box_of(*mesh_a, i, [](const fcl::Vector3d& v) { return v; });
        if (!box.overlaps(all_b)) continue;
        const Triangle& p = mesh_a->triangles[i];
        for (std::size_t j = 0; j < of_b.size(); ++j) {
            if (!box.overlaps(scratch[j])) continue;
            const Triangle& q = mesh_b->triangles[of_b[j]];
            if (fcl::detail::Intersect<double>::intersect_Triangle(
                    mesh_a->vertices[p[0]], mesh_a->vertices[p[1]], mesh_a->vertices[p[2]], mesh_b->vertices[q[0]],
                    mesh_b->vertices[q[1]], mesh_b->vertices[q[2]], r, t))
                return true;
        }
    }
    return false;
}

} // namespace oncollide
