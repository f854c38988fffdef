#pragma once
#include <variant>
#include <vector>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

// Primitive shapes: solid, metres; centred on their own origin.
struct Sphere {
    double radius;
};
struct Box {
    Eigen::Vector3d half;
};
struct Capsule {
    double radius, length;
}; ///< along z; `length` is the cylinder's, without the caps; >= 0
struct Cylinder {
    double radius, length;
}; ///< along z
struct ConvexHull {
    std::vector<Eigen::Vector3d> points;
}; ///< at least four, not in a plane

struct Ellipsoid {
    Eigen::Vector3d semi_axes;
};
struct Cone {
    double radius, length;
};                   ///< along z: the base at z = -length / 2, the apex at length / 2
struct HalfSpace {}; ///< all points with z <= 0: unbounded

using Shape = std::variant<Sphere, Box, Capsule, Cylinder, ConvexHull, Ellipsoid, Cone, HalfSpace>;

/// A half-space ends here for code that needs a finite box: beyond all poses and sizes, each up to 1e15 m.
constexpr double half_space_end = 0x1p52;

/// Throws Error{bad_data} naming `name` and the wrong dimension: not finite, not positive, so small that its products
/// lose digits (below 1e-60 m), flat hull.
ONCOLLIDE_API void check_shape(const std::string& name, const Shape& shape);

/// The exact AABB of the shape in its own frame; a half-space ends at half_space_end.
ONCOLLIDE_API Aabb bounds_of(const Shape& shape);

/// A convex closed mesh that encloses the shape.
struct BoundingMesh {
    Mesh mesh;             ///< outward orientation
    double covering_error; ///< upper bound on the distance of any point of the solid `mesh` from the shape (m)
};

/// Curved parts are tessellated so that the covering error is about 0.5 % of the radius (sphere 1,568 triangles). Boxes
/// are exact (0). Hulls are expanded by their rounding error: about 1e-12 of their size, up to 1e-6 if many points are
/// nearly coplanar. The mesh certainly encloses the shape, rounding included. The shape must have passed check_shape
/// and must not be a half-space.
ONCOLLIDE_API BoundingMesh bounding_mesh_of(const Shape& shape);

} // namespace oncollide
