#pragma once
#include <concepts>

#include <oncollide/base/function_ref.hpp>
#include <oncollide/narrowphase/finding.hpp>
#include <oncollide/narrowphase/pairs/pair_worker.hpp>
#include <oncollide/narrowphase/shapes/convex_pair.hpp>

namespace oncollide {

/// A body against the half-space z <= 0, in the half-space's frame. The body's least height decides: exactly for
/// meshes, boxes, hulls and cells (a corner as placed), and for spheres and capsules if the slack is 0; within rounding
/// for other shapes.
/// Body: Cells, Heights, Triangles, Solid or Plane.
template <class Body>
class HalfSpacePair {
public:
    /// Keeps references. A mesh must have its OBB tree. @param slack  see ConvexPair
    HalfSpacePair(Model& body, const RelativePose& body_to_plane, double slack);

    /// Cost: 20 ns for a shape, and for a body whose box is above the plane; otherwise a traversal of the tree's lowest
    /// part.
    ConvexMeeting meeting() const;
    /// The points are on the half-space and on the body. If the body's box is higher than `above`, there are no points
    /// and no upper bound.
    ConvexDistance distance(double above) const;
    struct Depth {
        double lower, upper;    ///< certified, rounding included; both infinite for two half-spaces that cross
        Eigen::Vector3d lowest; ///< the body's lowest point
    };
    /// How far the body's lowest point lies inside the half-space; 0 if it lies outside.
    Depth depth() const;
    /// For a body with a tree: calls found(part, lowest corner) for all parts that meet the half-space. A
    /// terrain's heights count as stored.
    void each_meeting(FunctionRef<void(const BodyPart&, const Eigen::Vector3d&)> found) const;

private:
    static constexpr bool is_solid = std::same_as<Body, operand::Solid>, is_plane = std::same_as<Body, operand::Plane>;

    /// The body's lowest point, without the radius around a core.
    Eigen::Vector3d lowest(double enough) const;
    double radius() const;   ///< radius around the core of a shape
    double rounding() const; ///< error bound of the body's height
    double low() const; ///< lower bound of the height of a body with a tree, rounding included; unknown for a shape

    Model& body_;
    const RelativePose& to_plane_;
    const double slack_;
};
extern template class HalfSpacePair<operand::Cells>;
extern template class HalfSpacePair<operand::Heights>;
extern template class HalfSpacePair<operand::Triangles>;
extern template class HalfSpacePair<operand::Solid>;
extern template class HalfSpacePair<operand::Plane>;

} // namespace oncollide
