#pragma once
#include <optional>

#include <oncollide/base/aabb.hpp>
#include <oncollide/narrowphase/exact/triangle_test.hpp>
#include <oncollide/narrowphase/shapes/convex.hpp>

namespace oncollide {

/// Certified bounds of the fraction of a segment, 0 to 1, at its first point in a part of a body.
struct SegmentEntry {
    double lower, upper;
    bool certain = true; ///< false: rounding hides whether there is a common point
};

// Nothing if the segment and the part have no common point. Whether they have one is exact for the coordinates as
// stored, touching counts; the bounds are at most 2^-46 of the fraction apart, also in the plane of a triangle. They
// are equal for a segment that begins in the part, or that only its end meets. A segment without length has the
// fraction 0.

std::optional<SegmentEntry> entry_of(const Segment& segment, const TrianglePoints& triangle);
/// The entry into a triangle whose plane the segment crosses.
SegmentEntry entry_across(const Segment& segment, const TrianglePoints& triangle);
std::optional<SegmentEntry> entry_of(const Segment& segment, const Aabb& cell); ///< solid

/// The half-space z <= 0.
std::optional<SegmentEntry> entry_in_half_space(const Segment& segment);

/// For a solid the result is certain except for rounding, as for ConvexPair::meeting(). The bounds are at most 2^-40
/// apart if the segment does not graze the solid; otherwise they enclose the part of the segment in which rounding
/// hides the entry. Cost: 45 decisions.
std::optional<SegmentEntry> entry_of(const Segment& segment, const Convex& solid);

/// The unit normal that faces the segment's first point; 0 if the segment is in the plane, or the triangle has no area.
Eigen::Vector3d normal_facing(const Segment& segment, const TrianglePoints& triangle);
/// The outward normal of the face through which the segment enters, the first axis at an edge; 0 if it begins in the
/// cell.
Eigen::Vector3d normal_facing(const Segment& segment, const Aabb& cell);

} // namespace oncollide
