#pragma once
#include <oncollide/narrowphase/relative_pose.hpp>
#include <oncollide/narrowphase/shapes/convex.hpp>

namespace oncollide {

/// The points b - a of the cores of two solids, in A's frame: the cores meet where 0 is among them, and are as far
/// apart as it is from them.
class ConvexDifference {
public:
    /// Keeps references. @param slack  see ConvexPair
    ConvexDifference(const Convex& a, const Convex& b, const RelativePose& b_to_a, double slack)
        : a_(a), b_(b), b_to_a_(b_to_a), slack_(slack), apart_(b_to_a.translation.norm())
    {
        // With u = 2^-53: a point of B, placed, is off by at most 9 u of its magnitude from the image of one of B's; a
        // round support point by 6 u of the core's size before that; the difference by u; its product with a direction,
        // over the direction's length, by 8 u. A direction turned into B's frame is off by 6 u of its length, and may
        // so choose a point that is too near by 12 u of B's size. Together below 64 u = 2^-47. The slack acts on what
        // is round: polytopes are what their vertices, as placed, are.
        const auto round_size = [](const Convex& c) { return c.radius + (c.flat_sided ? 0 : c.extent); };
        const double size = a.extent + b.extent;
        rounding_ =
            0x1p-47 * (size + apart_) + slack * (round_size(a) + round_size(b)) + 0x1p-50 * radius() + 0x1p-1000;
        // A point that is turned into B's frame is off by as much again, and by what the turn is not rigid.
        holding_ = 2 * rounding_ + 2 * slack * (size + radius());
    }

    struct Point {
        Eigen::Vector3d w; ///< b - a
        Eigen::Vector3d a;
    };
    /// A point that is farthest along d.
    Point support(const Eigen::Vector3d& d) const
    {
        const Eigen::Vector3d a = a_.support(-d);
        return {b_to_a_(b_.support(into_b(d))) - a, a};
    }
    const Convex& a() const { return a_; }
    const Convex& b() const { return b_; }
    const RelativePose& b_to_a() const { return b_to_a_; }
    double slack() const { return slack_; }
    /// A direction in B's frame.
    Eigen::Vector3d into_b(const Eigen::Vector3d& d) const { return b_to_a_.rotation.transpose() * d; }
    /// Is the one solid certainly inside the other at either of these points of theirs?
    bool one_holds(const Eigen::Vector3d& of_a, const Eigen::Vector3d& of_b) const
    {
        return a_.holds(of_b, holding_) || b_.holds(into_b(of_a - b_to_a_.translation), holding_);
    }
    bool flat_sided() const { return a_.flat_sided && b_.flat_sided; }
    double radius() const { return a_.radius + b_.radius; } ///< of the balls around both cores together
    double size() const { return a_.extent + b_.extent; }
    /// A point inside, with a ball of inner() around it.
    Eigen::Vector3d middle() const { return b_to_a_(b_.centre) - a_.centre; }
    double inner() const
    {
        return (a_.inner + b_.inner) * (1 - 0x1p-18) - rounding_;
    } ///< poses may be 2^-20 from rigid
    /// By how much a point may be off, and a product with a direction over the direction's length.
    double rounding() const { return rounding_; }
    /// No point is nearer to 0 than this, by the balls around the origins; may be below 0.
    double least() const { return apart_ * (1 - 0x1p-18) - a_.extent - b_.extent - rounding_; }

private:
    const Convex &a_, &b_;
    const RelativePose& b_to_a_;
    const double slack_, apart_;
    double rounding_, holding_;
};

} // namespace oncollide
