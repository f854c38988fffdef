// Geometries of DART's shapes.
#pragma once
#include <memory>

#include <dart/dynamics/Shape.hpp>
#include <dart/dynamics/SoftMeshShape.hpp>

#include <oncollide/scenes/geometry.hpp>

namespace dart::collision::oncollide_client {

/// A geometry, and its pose in the shape's frame.
struct PlacedGeometry {
    std::shared_ptr<const oncollide::Geometry> geometry;
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
};

/// Null, after a warning, for a shape that has no geometry in oncollide.
PlacedGeometry geometry_of(const dynamics::Shape& shape, bool solid_heightmaps);

/// The surface as it is now; its triangles are the faces of the shape, in order.
oncollide::Mesh mesh_of(const dynamics::SoftMeshShape& shape);
/// A face at the vertex that is nearest to a point in the shape's frame.
int face_near(const dynamics::SoftMeshShape& shape, const Eigen::Vector3d& point);

} // namespace dart::collision::oncollide_client
