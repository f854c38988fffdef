#pragma once
#include <memory>

#include <Eigen/Geometry>

#include <oncollide/scenes/geometry.hpp>

namespace oncollide {

/// False in builds without FCL (ONCOLLIDE_FCL=OFF), where the functions below throw.
bool fcl_available();

/// FCL's model of a geometry. Opaque: FCL's headers stay inside exact_fcl.cpp.
class FclModel;

/// A mesh becomes triangles in an OBB tree, a shape one of libccd's shapes, and a map an octree. Cost: about 3
/// microseconds per triangle.
std::shared_ptr<const FclModel> make_fcl_model(const GeometryData& geometry);

/// True if two bodies collide according to FCL. Thread-safe. FCL's distances are not used: libccd overstates them, and
/// aborts by an assertion where shapes touch.
bool fcl_collides(const FclModel& a, const Eigen::Isometry3d& pose_a, const FclModel& b,
                  const Eigen::Isometry3d& pose_b);

} // namespace oncollide
