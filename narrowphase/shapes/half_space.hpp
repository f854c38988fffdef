#pragma once
#include <oncollide/base/function_ref.hpp>
#include <oncollide/narrowphase/body_part.hpp>
#include <oncollide/narrowphase/model.hpp>
#include <oncollide/narrowphase/shapes/convex_pair.hpp>

namespace oncollide {

/// A body against the half-space z <= 0, in the half-space's frame. Its least height decides: of meshes, boxes, hulls
/// and cells that of a corner as placed, exactly; of spheres and capsules too where the slack is 0; of other shapes but
/// for rounding.
class HalfSpacePair {
public:
    /// Keeps references. A mesh must have its tree of oriented boxes. @param slack  see ConvexPair
    HalfSpacePair(Model& body, const RelativePose& body_to_plane, double slack);

    /// Cost: of a shape, and of a body whose box is above the plane, 20 ns; else that of walking down the tree where it
    /// is lowest.
    ConvexMeeting meeting() const;
    /// The points are on the half-space and on the body. Of one whose box is higher than `above` there are none, and no
    /// upper bound.
    ConvexDistance distance(double above) const;
    /// found(part, lowest corner) of all parts that come to the half-space, of a body that is no shape; a terrain's
    /// heights count as they are stored.
    void each_meeting(FunctionRef<void(const BodyPart&, const Eigen::Vector3d&)> found) const;

private:
    /// The body's lowest point, but for the radius around a core.
    Eigen::Vector3d lowest(double enough) const;
    double rounding() const; ///< of its height
    double low() const;      ///< no point of a body with a tree is lower, rounding included; of a shape: not known

    Model& body_;
    const RelativePose& to_plane_;
    const double slack_;
};

} // namespace oncollide
