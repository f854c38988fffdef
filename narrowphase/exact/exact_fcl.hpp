#pragma once
#include <memory>

#include <Eigen/Geometry>

#include <oncollide/scenes/scene.hpp>

namespace oncollide {

/// False in builds without FCL (ONCOLLIDE_FCL=OFF): there the functions below throw.
bool fcl_available();

/// FCL's model of a geometry. Opaque: FCL's headers stay inside exact_fcl.cpp.
class FclModel;

/// Triangles in a tree of oriented boxes for meshes, libccd's shapes, an octree for maps.
/// Cost: about 3 microseconds a triangle.
std::shared_ptr<const FclModel> make_fcl_model(const GeometryData& geometry);

/// Do two bodies collide, for FCL? Thread-safe. It is never asked for distances: libccd overstates them, and ends the
/// program by an assertion of its own where shapes touch.
bool fcl_collides(const FclModel& a, const Eigen::Isometry3d& pose_a, const FclModel& b,
                  const Eigen::Isometry3d& pose_b);

} // namespace oncollide
