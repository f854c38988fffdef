#pragma once
#include <algorithm>
#include <cmath>

#include <Eigen/Core>

#include <oncollide/narrowphase/exact/relative_pose.hpp>
#include <oncollide/narrowphase/obb/box_node.hpp>

namespace oncollide {

/// The frame in which the boxes of two hierarchies are compared, and the rounding errors of the distances found there.
///
/// Coordinates are A's, from the centre of the smaller geometry: points near a small body are then resolved to
/// fractions of the body, however large the terrain below it is.
///
/// Errors of floats, with u = 2^-24: dx joins the centres of two boxes; s is the sum of their half-extents and of their
/// centres' distances from the origins of their nodes. Moved centres and axes, and the projections onto the fifteen
/// axes, err by at most 80 u |dx|, 80 u s, and 40 u times the smaller radius. The relative pose may be 2^-19 = 32 u
/// from a rotation (two poses, each 2^-20), so a box's own axes may not be orthogonal: 256 u s. The boxes are at least
/// |dx| - s apart. Together, a gap is at most the distance times 1 + 2^-17, plus 420 u s, plus box_rounding; the nodes'
/// margins are at least 420 u s. RelativePose rounds in double, relative to the files' origins and to the bodies'
/// distance: a placed coordinate errs by at most 7 u |p| + 6 u |translation| with u = 2^-53, a placed point by less
/// than 2^-49 of the sum of both. Half of leaf_rounding covers this error; the other half is for measuring placed
/// primitives.
struct WalkFrame {
    BoxPlacement place_a, place_b;
    Eigen::Vector3d origin; ///< origin of the coordinates, in A's frame
    double box_rounding;    ///< error bound of gaps between boxes
    double leaf_rounding;   ///< error bound of distances between primitives
    double placement;       ///< error bound of the distance of two points as placed by the relative pose
    double apart;           ///< lower bound of the distance of the spheres around the geometries

    /// @param reach  if the spheres are farther apart, only `apart` is set
    WalkFrame(const auto& a, const auto& b, const RelativePose& b_to_a, double reach)
    {
        const Eigen::Matrix3d& r = b_to_a.rotation;
        const Eigen::Vector3d d = b_to_a(b.centre()) - a.centre();
        const double both = a.radius() + b.radius(), length = d.norm(), m = length + both;
        const auto sum = [](const Eigen::Vector3d& v) { return std::abs(v[0]) + std::abs(v[1]) + std::abs(v[2]); };
        // Sums of magnitudes, without roots.
        const double at_most_far = sum(a.centre()) + sum(b.centre()) + sum(b_to_a.translation);
        // The translation of B, which only corrects the origin's rounding, is shorter than 2^-17 of the distance.
        box_rounding =
            0x1p-18 * std::min(a.radius(), b.radius()) + 0x1p-37 * length + 0x1p-48 * (m + at_most_far) + 1e-30;
        apart = (length - (1 + 0x1p-18) * both) * (1 - 0x1p-18) - box_rounding;
        if (apart > reach) return;
        const double far = a.centre().norm() + b.centre().norm() + b_to_a.translation.norm();
        placement = 0x1p-49 * (m + far);
        leaf_rounding = std::max(0x1p-38 * m, 0x1p-48 * far) + 1e-150; // squares of smaller distances underflow
        const bool from_a = a.radius() < b.radius();
        for (int i = 0; i < 3; ++i) { // the points that become the origin
            place_a.from[i] = from_a ? 0 : static_cast<float>(d[i]);
            place_b.from[i] = from_a ? static_cast<float>(-(r(0, i) * d[0] + r(1, i) * d[1] + r(2, i) * d[2])) : 0;
        }
        place_a.rotated = false, place_b.rotated = true;
        for (int i = 0; i < 3; ++i) {
            const double from = double(place_a.from[i]);
            const double moved = r(i, 0) * place_b.from[0] + r(i, 1) * place_b.from[1] + r(i, 2) * place_b.from[2];
            origin[i] = a.centre()[i] + from;
            place_b.translation[i] = static_cast<float>(d[i] + moved - from);
            for (int j = 0; j < 3; ++j) place_b.rotation[3 * i + j] = static_cast<float>(r(i, j));
        }
    }
    /// The lower bound of the distance of primitives whose distance as placed is at least `gap`. Poses may be 2^-20
    /// from rigid; that takes more from large gaps than the rounding of the placement does. Below this rounding only
    /// the placed primitives have a distance, so the bound is their distance, > 0 unless they touch.
    double placed_at_least(double gap) const
    {
        if (gap < 0x1p18 * placement) gap = std::max(gap - placement, std::min(gap, placement));
        return gap * (1 - 0x1p-18);
    }
    /// The lower bound of the distance that a gap proves.
    double at_least(double gap) const { return (gap - box_rounding) * (1 - 0x1p-17); }
    /// Boxes with a larger gap hold no primitives within `distance`.
    float gap_within(double distance) const { return static_cast<float>((distance + box_rounding) * (1 + 0x1p-16)); }
};

/// A direction in A's frame and in B's, of length 1 at most. The projection of a point of B in A's frame is its
/// projection in B's frame plus `shift`.
struct WalkLine {
    Eigen::Vector3d in_a = Eigen::Vector3d::Zero(), in_b = in_a;
    double shift = 0;

    WalkLine() = default;
    WalkLine(const Eigen::Vector3d& between, const RelativePose& b_to_a)
    {
        if (const double length = between.norm() * (1 + 0x1p-50); length > 0) in_a = between / length;
        in_b = b_to_a.rotation.transpose() * in_a, shift = in_a.dot(b_to_a.translation);
    }
};

} // namespace oncollide
