#pragma once
#include <oncollide/scenes/model/shape.hpp>

namespace oncollide {

/// Is the shape a box or a hull?
inline bool is_polytope(const Shape& shape)
{
    return std::holds_alternative<Box>(shape) || std::holds_alternative<ConvexHull>(shape);
}

/// The surface of a box or a hull exactly, outward orientation, of its corners alone; of others no triangles. The shape
/// must have passed check_shape.
Mesh surface_of_polytope(const Shape& shape);

} // namespace oncollide
