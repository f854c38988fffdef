#pragma once
#include <optional>

#include <oncollide/scenes/model/shape.hpp>

namespace oncollide {

/// A shape as exact tests take it: all points within `radius` of a polytope. A box is its corners, a hull its surface,
/// a sphere a point, a capsule a segment, each exactly. A cylinder lies between two prisms.
struct ShapeCore {
    Mesh inner;                ///< a closed convex surface, a segment or a point: triangles without area
    double radius = 0;         ///< metres
    std::optional<Mesh> outer; ///< of a cylinder: holds it, as it holds `inner`
    double error = 0;          ///< no point of the shape is farther than this from `inner` and the ball around it

    bool polytope() const { return radius == 0 && !outer; }
    bool has_volume() const { return radius == 0; } ///< does `inner` enclose points?
};

/// The shape must have passed check_shape.
ShapeCore core_of(const Shape& shape);

} // namespace oncollide
