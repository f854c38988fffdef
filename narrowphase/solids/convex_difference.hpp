#pragma once
#include <oncollide/narrowphase/relative_pose.hpp>
#include <oncollide/narrowphase/solids/convex.hpp>

namespace oncollide {

/// The points b - a of the cores of two solids, in A's frame: the cores meet where 0 is among them, and are as far
/// apart as it is from them.
class ConvexDifference {
public:
    /// @param slack  by how much points may be off besides rounding, metres
    ConvexDifference(const Convex& a, const Convex& b, const RelativePose& b_to_a, double slack = 0)
        : a_(a), b_(b), b_to_a_(b_to_a), apart_(b_to_a.translation.norm())
    {
        // With u = 2^-53: a point of B, placed, is off by at most 9 u of its magnitude from the image of one of B's; a
        // round support point by 6 u of the core's size before that; the difference by u; its product with a direction,
        // over the direction's length, by 8 u. A direction turned into B's frame is off by 6 u of its length, and may
        // so choose a point that is too near by 12 u of B's size. Together below 64 u = 2^-47.
        rounding_ = 0x1p-47 * (a.extent + b.extent + apart_) + slack + 0x1p-1000;
    }

    struct Point {
        Eigen::Vector3d w; ///< b - a
        Eigen::Vector3d a;
    };
    /// A point that is farthest along d.
    Point support(const Eigen::Vector3d& d) const
    {
        const Eigen::Vector3d a = a_.support(-d);
        return {b_to_a_(b_.support(b_to_a_.rotation.transpose() * d)) - a, a};
    }
    bool flat_sided() const { return a_.flat_sided && b_.flat_sided; }
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
    double apart_, rounding_;
};

} // namespace oncollide
