#include "fcl/fcl_pair.hpp"

#include <fcl/narrowphase/continuous_collision.h>

#include <oncollide/narrowphase/fcl/fcl_geometry.hpp>

namespace oncollide::tools {
namespace {

const Eigen::Isometry3d nowhere = Eigen::Isometry3d::Identity();

FclGeometry make_tree(const Mesh& mesh, FclNodes nodes)
{
    return nodes == FclNodes::obb ? make_fcl_tree<fcl::OBBd>(mesh) : make_fcl_tree<fcl::OBBRSSd>(mesh);
}

/// The result belongs to this thread and is overwritten by the next call, which saves allocations.
const fcl::CollisionResultd& collide(const FclBody& a, const FclBody& b, std::size_t most, bool details)
{
    const fcl::CollisionRequestd request(most, details);
    thread_local fcl::CollisionResultd result;
    result.clear();
    fcl::collide(a.geometry.get(), a.pose, b.geometry.get(), b.pose, request, result);
    return result;
}

} // namespace

FclGeometry make_fcl_geometry(const GeometryData& geometry, FclNodes nodes,
                              std::shared_ptr<const octomap::OcTree> octree)
{
    FclGeometry made;
    if (const auto* mesh = std::get_if<Mesh>(&geometry))
        made = make_tree(*mesh, nodes);
    else if (const auto* terrain = std::get_if<Terrain>(&geometry))
        made = make_tree(mesh_of(*terrain), nodes);
    else if (const auto* shape = std::get_if<Shape>(&geometry))
        made = std::visit(FclShape{}, *shape);
    else
        made = std::make_shared<fcl::OcTreed>(octree ? octree : make_octree(std::get<OccupancyMap>(geometry)));
    made->computeLocalAABB();
    return made;
}

std::size_t fcl_contacts(const FclBody& a, const FclBody& b, std::size_t most, bool details)
{
    return collide(a, b, most, details).numContacts();
}

double fcl_distance(const FclBody& a, const FclBody& b)
{
    const fcl::DistanceRequestd request;
    fcl::DistanceResultd result;
    return std::max(0.0, fcl::distance(a.geometry.get(), a.pose, b.geometry.get(), b.pose, request, result));
}

double fcl_time_of_contact(const FclBody& a, const Eigen::Isometry3d& to_a, const FclBody& b,
                           const Eigen::Isometry3d& to_b, FclSweep how, double tolerance)
{
    fcl::ContinuousCollisionRequestd request;
    if (how == FclSweep::advancement) {
        request.toc_err = tolerance;
        request.ccd_motion_type = fcl::CCDM_LINEAR, request.ccd_solver_type = fcl::CCDC_CONSERVATIVE_ADVANCEMENT;
    }
    fcl::ContinuousCollisionResultd result;
    fcl::continuousCollide(a.geometry.get(), a.pose, to_a, b.geometry.get(), b.pose, to_b, request, result);
    return result.is_collide ? result.time_of_contact : std::numeric_limits<double>::infinity();
}

std::size_t fcl_mesh_bytes(const FclGeometry& geometry, FclNodes as)
{
    // FCL's own memUsage() returns a status, not a size.
    const auto* mesh = dynamic_cast<const fcl::BVHModel<fcl::OBBd>*>(geometry.get());
    if (!mesh) return 0;
    const std::size_t node = as == FclNodes::obb ? sizeof(fcl::BVNode<fcl::OBBd>) : sizeof(fcl::BVNode<fcl::OBBRSSd>);
    return static_cast<std::size_t>(mesh->getNumBVs()) * node +
           static_cast<std::size_t>(mesh->num_tris) * (sizeof(fcl::Triangle) + sizeof(int)) +
           static_cast<std::size_t>(mesh->num_vertices) * sizeof(fcl::Vector3d);
}

FclPair::FclPair(const Mesh& a, const Mesh& b, FclNodes nodes) : a_(make_tree(a, nodes)), b_(make_tree(b, nodes)) {}

std::size_t FclPair::contacts(const Eigen::Isometry3d& b, std::size_t most) const
{
    return fcl_contacts({a_, nowhere}, {b_, b}, most);
}

void FclPair::for_pairs(const Eigen::Isometry3d& b, FunctionRef<void(std::uint32_t a, std::uint32_t b)> look) const
{
    const fcl::CollisionResultd& result = collide({a_, nowhere}, {b_, b}, 1'000'000'000, false);
    for (std::size_t k = 0; k < result.numContacts(); ++k) {
        const fcl::Contactd& contact = result.getContact(k);
        look(std::uint32_t(contact.b1), std::uint32_t(contact.b2));
    }
}

double FclPair::distance(const Eigen::Isometry3d& b) const
{
    return fcl_distance({a_, nowhere}, {b_, b});
}

} // namespace oncollide::tools
