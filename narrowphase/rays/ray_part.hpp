#pragma once
#include <cmath>

#include <oncollide/broadphase/segment_part.hpp>
#include <oncollide/narrowphase/rays/tree/ray_node.hpp>

namespace oncollide {

/// The part of a segment in the bounds of a geometry, as the walks of rays need it.
struct RayPart {
    Eigen::Vector3d middle;    ///< relative to the geometry's centre, within `error` metres
    Eigen::Vector3d direction; ///< of length 1; 0 for a point
    double half, error;
    double before, after; ///< the segment's ends are this far from the middle, metres
    double begin, length; ///< fractions of the segment: where the part begins, and its share
    RayLine line;         ///< from the part's begin
    double widened;       ///< how far the line's coordinates are widened, metres

    /// @param centre, radius  of a sphere around the geometry
    /// @param rounding        error bound of the coordinates of the geometry's triangles
    RayPart(const Segment& segment, const SegmentPart& part, const Eigen::Vector3d& centre, double radius,
            double rounding)
        : middle(part.middle - centre), direction(segment.to - segment.from), half(part.half.norm()),
          error(part.error + rounding), begin(part.begin), length(part.end - part.begin)
    {
        const double norm = direction.norm();
        direction *= norm > 1e-100 ? 1 / norm : 0;
        before = (begin + 0.5 * length) * norm, after = (1 - begin - 0.5 * length) * norm;
        // With u = 2^-24, the begin errs by u of a coordinate, a box by 2 u of its distance from there, and t times the
        // direction by 4 u of that: at most 16 u of the radius in all.
        widened = error + 0x1p-18 * radius + 1e-30;
        for (int axis = 0; axis < 3; ++axis) {
            constexpr double least = 1e-18;
            const double d = direction[axis], from = middle[axis] - part.half[axis];
            line.inverse[axis] = static_cast<float>(1 / (std::abs(d) > least ? d : std::copysign(least, d)));
            line.from_less[axis] = static_cast<float>(from - widened);
            line.from_more[axis] = static_cast<float>(from + widened);
        }
    }
    /// True if all points of the line within `reach` metres of one of its points are certainly in the segment.
    /// @param along  the position of that point, from the middle
    bool covers(double along, double reach) const
    {
        return along - reach - error >= -before && along + reach + error <= after;
    }
    /// An upper bound of the farthest t of interest; negative: none is.
    /// @param reach  the farthest fraction of interest
    float last(double reach) const
    {
        if (reach < begin) return -1;
        const double t = length > 0 ? 2 * half * (reach - begin) / length : 0;
        return static_cast<float>((t + error) * (1 + 0x1p-20) + 1e-30);
    }
};

} // namespace oncollide
