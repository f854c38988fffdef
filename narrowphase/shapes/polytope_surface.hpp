#pragma once
#include <oncollide/scenes/model/shape.hpp>

namespace oncollide {

/// True if the shape is a box or a hull.
inline bool is_polytope(const Shape& shape)
{
    return std::holds_alternative<Box>(shape) || std::holds_alternative<ConvexHull>(shape);
}

/// The exact surface of a box or a hull, with outward orientation, made of its corners alone; no triangles for other
/// shapes. The shape must have passed check_shape.
Mesh surface_of_polytope(const Shape& shape);

} // namespace oncollide
