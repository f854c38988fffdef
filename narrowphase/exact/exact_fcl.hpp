#pragma once
#include <memory>

#include <Eigen/Geometry>

#include <oncollide/narrowphase/verdict.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide {

/// False in builds without FCL (ONCOLLIDE_FCL=OFF): there the functions below throw.
bool fcl_available();

/// FCL's model of a geometry. Opaque: FCL's headers stay inside exact_fcl.cpp.
class FclModel;

/// Triangles in a tree of oriented boxes for meshes, libccd's shapes, an octree for maps.
/// @param for_distances  whether distances will be requested too, which need another kind of tree
/// Cost: about 3 microseconds a triangle.
std::shared_ptr<const FclModel> make_fcl_model(const GeometryData& geometry, bool for_distances);

struct FclResult {
    Verdict verdict; ///< colliding, within (not colliding, distance <= clearance) or separate
    double bound;    ///< colliding: 0; else the distance when clearance > 0, else 0
};

/// The exact level by way of FCL, on two bodies as a whole. Thread-safe.
/// @param clearance  metres; above 0 distances are computed too
FclResult fcl_result(const FclModel& a, const Eigen::Isometry3d& pose_a, const FclModel& b,
                     const Eigen::Isometry3d& pose_b, double clearance);

} // namespace oncollide
