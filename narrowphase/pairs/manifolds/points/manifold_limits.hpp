// The thresholds of manifolds, each with its unit and its reason. Bounds of rounding stand where they are derived.
#pragma once
#include <cstddef>
#include <numbers>

namespace oncollide::manifold_limits {

// --- Directions of faces.

/// 20 degrees. Normals of opposite faces differ by at most this.
constexpr double facing_cosine = 0.9396926;
/// 2 degrees. A region is curved if the normal of a point differs by more from its normal.
constexpr double curved_cosine = 0.9994;
/// 45 degrees. A point whose own normal differs by more has the normal of its region: a solver pushes along it.
constexpr double point_cosine = std::numbers::sqrt2 / 2;
/// Radians. If no normal differs by more from the region's, the region is flat, and all get its normal.
constexpr double level_angle = 1e-3;
/// 8 degrees. Points at one place whose normals differ by less give a solver the same equation.
constexpr double repeated_cosine = 0.99;
/// Radians; a factor; radians. Where a pair has more directions than it may have regions, the spread of a region begins
/// at the first, grows by the second, and ends at the third: faces of one region do not turn their backs to each other.
constexpr double least_widened = 0.05, widening = 1.5, most_spread = std::numbers::pi / 3;

// --- Faces ahead of a point.

/// Sine of the angle between line and face. On a steeper face the depth errs by 10^6 times the rounding or more.
constexpr double least_slope = 1e-6;
/// Barycentric. A line that misses a face by less counts as crossing it, so that neighbouring faces leave no gap.
constexpr double beside_face = 1e-9;
/// Share of the depth. A shorter way out leads through a face of another region.
constexpr double through_share = 0.999;
/// Candidates times faces. If there are more rays, only the points that are kept get exact depths. A ray takes 2 ns.
constexpr std::size_t most_rays = 1 << 10;

// --- The choice of points.

/// Share of a region's size. Points that are less apart are at one place. Points that are
/// less deep than the deepest by this share count as the deepest, too.
constexpr double same_share = 1e-6;
/// Share of a region's size. The deepest of several points that are equally far out is kept, unless depths differ by
/// less.
constexpr double same_depth_share = 1e-9;
/// Share of the square root of a region's area. Points of two regions that are less apart are at one place.
constexpr double repeated_share = 1e-4;
/// Points. A hull of at most this many points stores all triangles of its points, at most 20; a larger hull stores a
/// fan.
constexpr std::size_t most_hull_points = 6;

// --- Directions of an overlap.

/// Directions of one lump. Each costs a comparison per triangle.
constexpr std::size_t most_facings = 64;
/// Share of the largest area of a direction. Directions with less have no region.
constexpr double matched_share = 0.05;
/// A factor of the least thickness of a direction; a share of the square root of its area. Faces that are farther apart
/// than both are far sides of the overlap, not in contact.
constexpr double thick_factor = 4, thin_share = 0.1;
/// Share of the area of a surface's pieces. If less is left in the sum of the pieces, one body goes through the other,
/// and no normal parts the bodies.
constexpr double least_flat_share = 0.5;
/// Roundings of coordinates. A thinner lump has no certain volume.
constexpr double touching_roundings = 16;

// --- Surfaces that touch or are near.

/// Length of the sum or the cross product of unit vectors. Rounding leaves a shorter vector no certain direction.
constexpr double least_direction = 1e-6;
/// Length of the sum of unit vectors. Where it is shorter they cancel out, and the first counts.
constexpr double least_near_direction = 0.1;
/// Cosine. If a distance falls by less along a face, it counts as a minimum, because of rounding.
constexpr double rising = 1e-9;
/// Cosine. A point that is farther behind all faces around a corner or an edge is behind the surface.
constexpr double behind_share = -0.5;
/// Triangles that are looked at around a corner.
constexpr int most_around = 64;

} // namespace oncollide::manifold_limits
