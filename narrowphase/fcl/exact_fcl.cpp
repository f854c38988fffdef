#include <oncollide/narrowphase/fcl/exact_fcl.hpp>

#include <new>

#include <fcl/fcl.h>

#include <oncollide/scenes/model/convex_hull.hpp>

namespace oncollide {

namespace {

using ModelPtr = std::shared_ptr<fcl::CollisionGeometryd>;

ModelPtr make_bvh(const Mesh& mesh)
{
    auto model = std::make_shared<fcl::BVHModel<fcl::OBBd>>();
    std::vector<fcl::Triangle> triangles;
    triangles.reserve(mesh.triangles.size());
    for (const Triangle& t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
    // If the triangles are valid, only memory can be lacking; a model built regardless would crash.
    const auto made = [](int result) {
        if (result != fcl::BVH_OK) throw std::bad_alloc();
    };
    made(model->beginModel(static_cast<int>(triangles.size()), static_cast<int>(mesh.vertices.size())));
    made(model->addSubModel(mesh.vertices, triangles));
    made(model->endModel());
    return model;
}

struct ShapeModel {
    ModelPtr operator()(const Sphere& s) const { return std::make_shared<fcl::Sphered>(s.radius); }
    ModelPtr operator()(const Box& b) const { return std::make_shared<fcl::Boxd>(fcl::Vector3d(2 * b.half)); }
    ModelPtr operator()(const Capsule& c) const { return std::make_shared<fcl::Capsuled>(c.radius, c.length); }
    ModelPtr operator()(const Cylinder& c) const { return std::make_shared<fcl::Cylinderd>(c.radius, c.length); }
    ModelPtr operator()(const Ellipsoid& e) const { return std::make_shared<fcl::Ellipsoidd>(e.semi_axes); }
    ModelPtr operator()(const Cone& c) const { return std::make_shared<fcl::Coned>(c.radius, c.length); }
    ModelPtr operator()(const HalfSpace&) const { return std::make_shared<fcl::Halfspaced>(fcl::Vector3d::UnitZ(), 0); }
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

} // namespace

bool fcl_available()
{
    return true;
}

class FclModel {
public:
    explicit FclModel(ModelPtr geometry) : geometry_(std::move(geometry)) { geometry_->computeLocalAABB(); }
    const fcl::CollisionGeometryd* get() const { return geometry_.get(); }

private:
    ModelPtr geometry_;
};

std::shared_ptr<const FclModel> make_fcl_model(const GeometryData& geometry)
{
    if (const auto* mesh = std::get_if<Mesh>(&geometry)) return std::make_shared<FclModel>(make_bvh(*mesh));
    if (const auto* shape = std::get_if<Shape>(&geometry))
        return std::make_shared<FclModel>(std::visit(ShapeModel{}, *shape));
    if (const auto* terrain = std::get_if<Terrain>(&geometry))
        return std::make_shared<FclModel>(make_bvh(mesh_of(*terrain)));
    return std::make_shared<FclModel>(std::make_shared<fcl::OcTreed>(make_octree(std::get<OccupancyMap>(geometry))));
}

bool fcl_collides(const FclModel& a, const Eigen::Isometry3d& pose_a, const FclModel& b,
                  const Eigen::Isometry3d& pose_b)
{
    fcl::CollisionRequestd request(1, false);
    fcl::CollisionResultd result;
    fcl::collide(a.get(), pose_a, b.get(), pose_b, request, result);
    return result.isCollision();
}

} // namespace oncollide
