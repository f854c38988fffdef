#pragma once
#include <array>

#include <oncollide/narrowphase/obb/hierarchy.hpp>
#include <oncollide/narrowphase/shapes/convex.hpp>

namespace oncollide {

/// A bounded shape as a BoxHierarchy: one box around one primitive.
class ShapeTree {
public:
    /// Keeps a reference. @param bounds  the shape's bounds
    ShapeTree(const Convex& shape, const Aabb& bounds)
        : shape_(shape), centre_(bounds.centre()), half_(bounds.half_extent() * (1 + 0x1p-20)), radius_(half_.norm())
    {
    }
    using Node = std::uint32_t;
    using Primitive = std::uint32_t;
    static constexpr Node root = 0;

    const Convex& shape() const { return shape_; }
    const Eigen::Vector3d& centre() const { return centre_; }
    const Eigen::Vector3d& half() const { return half_; } ///< half-extents of the box around it, along the shape's axes
    double radius() const { return radius_; }
    LaneMasks open(Node, const BoxPlacement* placement, OpenBoxes& boxes) const;
    Node child(Node node, unsigned) const { return node; }
    std::array<Primitive, 1> primitives(Node, unsigned) const { return {0}; }

private:
    const Convex& shape_;
    Eigen::Vector3d centre_, half_;
    double radius_;
};

} // namespace oncollide
