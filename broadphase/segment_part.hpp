#pragma once
#include <optional>

#include <oncollide/base/aabb.hpp>
#include <oncollide/broadphase/segment_line.hpp>

namespace oncollide {

/// The part of a segment in a box.
struct SegmentPart {
    double begin, end; ///< fractions of the segment, 0 to 1
    double error;      ///< metres: the part contains all points of the segment in the box, within this error
    Eigen::Vector3d middle, half;
};

/// The part of the segment in a box; nothing if the segment misses the box by more than rounding (2^-46 of the largest
/// coordinate). Coordinates are finite and at most 1e30 m.
std::optional<SegmentPart> part_in(const Segment& segment, const Aabb& box);

/// The part in floats relative to `origin`.
/// @param radius  upper bound of the distance from the origin to the part, metres; it must also bound the boxes'
///                points, unless the test of boxes allows for the rounding of their coordinates
SegmentLine line_of(const SegmentPart& part, const Eigen::Vector3d& origin, double radius);

} // namespace oncollide
