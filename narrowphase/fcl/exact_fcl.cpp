#include <oncollide/narrowphase/fcl/exact_fcl.hpp>

#include <oncollide/narrowphase/fcl/fcl_geometry.hpp>

namespace oncollide {

bool fcl_available()
{
    return true;
}

class FclModel {
public:
    explicit FclModel(FclGeometry geometry) : geometry_(std::move(geometry)) { geometry_->computeLocalAABB(); }
    const fcl::CollisionGeometryd* get() const { return geometry_.get(); }

private:
    FclGeometry geometry_;
};

std::shared_ptr<const FclModel> make_fcl_model(const GeometryData& geometry)
{
    if (const auto* mesh = std::get_if<Mesh>(&geometry))
        return std::make_shared<FclModel>(make_fcl_tree<fcl::OBBd>(*mesh));
    if (const auto* shape = std::get_if<Shape>(&geometry))
        return std::make_shared<FclModel>(std::visit(FclShape{}, *shape));
    if (const auto* terrain = std::get_if<Terrain>(&geometry))
        return std::make_shared<FclModel>(make_fcl_tree<fcl::OBBd>(mesh_of(*terrain)));
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
