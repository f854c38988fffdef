#pragma once
#include <oncollide/narrowphase/exact/relative_pose.hpp>
#include <oncollide/narrowphase/shapes/convex.hpp>

namespace oncollide {

/// The points b - a of the cores of two solids, in A's frame: the cores meet if 0 is among these points, and their
/// distance is the distance of 0 from them.
class ConvexDifference {
public:
    /// Keeps references. @param slack  see ConvexPair
    ConvexDifference(const Convex& a, const Convex& b, const RelativePose& b_to_a, double slack)
        : a_(a), b_(b), b_to_a_(b_to_a), slack_(slack), apart_(b_to_a.translation.norm())
    {
        // With u = 2^-53: a placed point of B errs by at most 9 u of its magnitude; a round support point by 6 u of the
        // core's size before that; the difference by u; its product with a direction, divided by the direction's
        // length, by 8 u. A direction rotated into B's frame errs by 6 u of its length, and may therefore choose a
        // point that is too near by 12 u of B's size. Together the errors are below 64 u = 2^-47. The slack applies to
        // round solids: a polytope is defined by its vertices as placed.
        const auto round_size = [](const Convex& c) { return c.radius + (c.flat_sided ? 0 : c.extent); };
        const double size = a.extent + b.extent;
        rounding_ =
            0x1p-47 * (size + apart_) + slack * (round_size(a) + round_size(b)) + 0x1p-50 * radius() + 0x1p-1000;
        // A point moved into B's frame errs by as much again, and by the rotation's deviation from rigid.
        holding_ = 2 * rounding_ + 2 * slack * (size + radius());
    }

    struct Point {
        Eigen::Vector3d w; ///< b - a
        Eigen::Vector3d a;
    };
    /// The support point along d.
    Point support(const Eigen::Vector3d& d) const
    {
        const Eigen::Vector3d a = a_.support(-d);
        return {b_to_a_(b_.support(into_b(d))) - a, a};
    }
    const Convex& a() const { return a_; }
    const Convex& b() const { return b_; }
    const RelativePose& b_to_a() const { return b_to_a_; }
    double slack() const { return slack_; }
    /// Rotates a direction into B's frame.
    Eigen::Vector3d into_b(const Eigen::Vector3d& d) const { return b_to_a_.rotation.transpose() * d; }
    /// True if A certainly contains of_b, a point of B, or B certainly contains of_a, a point of A.
    bool one_holds(const Eigen::Vector3d& of_a, const Eigen::Vector3d& of_b) const
    {
        return a_.holds(of_b, holding_) || b_.holds(into_b(of_a - b_to_a_.translation), holding_);
    }
    bool flat_sided() const { return a_.flat_sided && b_.flat_sided; }
    double radius() const { return a_.radius + b_.radius; } ///< sum of the swept spheres' radii
    double size() const { return a_.extent + b_.extent; }
    /// A point inside, with a sphere of radius inner() around it.
    Eigen::Vector3d middle() const { return b_to_a_(b_.centre) - a_.centre; }
    double inner() const
    {
        return (a_.inner + b_.inner) * (1 - 0x1p-18) - rounding_;
    } ///< poses may be 2^-20 from rigid
    /// Error bound of a point, and of its product with a direction divided by the direction's length.
    double rounding() const { return rounding_; }
    /// Lower bound of the distance from 0, by the spheres around the origins; may be negative.
    double least() const { return apart_ * (1 - 0x1p-18) - a_.extent - b_.extent - rounding_; }

private:
    const Convex &a_, &b_;
    const RelativePose& b_to_a_;
    const double slack_, apart_;
    double rounding_, holding_;
};

} // namespace oncollide
