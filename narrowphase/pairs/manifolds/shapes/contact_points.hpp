#pragma once
#include <oncollide/narrowphase/pairs/manifolds/shapes/few_points.hpp>

namespace oncollide {

/// The point of a solid's surface at a point of its core. Around a segment the surface is a cylinder, and a ball at its
/// ends. @param axis  of a segment, unit, @param height  of the point along the axis, from the segment's middle
/// @param out  unit
/// @param rounding  of the height, metres
Eigen::Vector3d surface_at(const Convex& c, const Eigen::Vector3d& axis, double height, const Eigen::Vector3d& at,
                           const Eigen::Vector3d& out, double rounding);

/// The points of two solids A and B across a normal, from their faces along it. One frame.
class ContactPoints {
public:
    /// Cosine of 10 degrees. A face that is more oblique to the normal has no points but the deepest.
    static constexpr double facing = 0.985;
    /// Sine. Segments that differ by more have one point.
    static constexpr double along_each_other = 0.05;

    Eigen::Vector3d normal; ///< unit, from A to B
    FewPoints points;

    /// @param on_a, on_b  points of the surfaces; the second is moved onto the line along the normal through the first
    /// @param off  metres: how far both may be from the surfaces
    void add(const Eigen::Vector3d& on_a, const Eigen::Vector3d& on_b, double off, FeatureBits of_a, FeatureBits of_b);
    /// Adds the corners of the part of a face that lies over a flat face, or over a plane: a face without corners
    /// through the origin. @param solid  whose core the face belongs to
    /// @param rounding  metres: a point may lie this far outside of the flat face
    void add_over(const ContactFace& flat, const ContactFace& face, const Convex& solid, bool flat_is_a,
                  double rounding);
    /// Adds the ends of the common part of two segments that lie along each other.
    void add_along(const ContactFace& face_a, const Convex& a, const ContactFace& face_b, const Convex& b);

private:
    ClippedFace clipped_;
    ContactFace surface_;
};

} // namespace oncollide
