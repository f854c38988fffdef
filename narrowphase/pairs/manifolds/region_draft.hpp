// A region before its points are chosen.
#pragma once
#include <limits>
#include <vector>

#include <oncollide/narrowphase/finding.hpp>
#include <oncollide/narrowphase/pairs/manifolds/overlap_patches.hpp>

namespace oncollide {

constexpr double unbounded = std::numeric_limits<double>::infinity();

/// A point that a region may keep.
struct ManifoldCandidate {
    enum Of : std::uint8_t { of_a, of_b, of_both }; ///< on whose surface the point is; the other's is opposite to it
    Eigen::Vector3d at;
    Of of;
    FeatureBits a, b; ///< 0: not known yet
    double depth = 0; ///< estimated until the point is kept, unless it is of both
    double error = 0;
    bool opposite = true; ///< a point opposite to it was found
};

/// In the frame of the pair.
struct RegionDraft {
    ManifoldRegion region{};
    std::vector<ManifoldCandidate> candidates;
    std::vector<Eigen::Vector3d> contacts; ///< exact contacts of the region, besides the candidates
    std::vector<std::pair<std::uint32_t, TrianglePoints>> faces_a, faces_b; ///< where opposite points are, by triangle
    double rounding = 0;                                                    ///< of positions, metres
    double least_depth = 0; ///< shallower points are dropped if others are left
};

/// Chooses the points, completes the region, and appends both. Drops the draft if it has no point.
void finish(RegionDraft& draft, const PlacedSurface& a, const PlacedSurface& b, const ManifoldOptions& options,
            Manifold& manifold);

/// Appends the regions of all lumps whose common volume is not rounding alone; sets `done` for these.
void add_crossing_regions(const OverlapPatches& overlap, const PlacedSurface& a, const PlacedSurface& b,
                          const ManifoldOptions& options, Manifold& manifold, std::vector<bool>& done);

/// Appends regions of pairs of triangles that meet without a common volume.
void add_touching_regions(std::span<const TrianglePair> pairs, const PlacedSurface& a, const PlacedSurface& b,
                          const ManifoldOptions& options, Manifold& manifold);

/// The support point of a round solid along a direction (unit, frame of the solid), and other points of its surface on
/// which the solid may lie: ends of a line, corners of a disc.
std::vector<Eigen::Vector3d> support_points(const Convex& solid, const Eigen::Vector3d& direction);

/// The angle between directions, within rounding; pi if a vector has no length.
double angle_between(const Eigen::Vector3d& u, const Eigen::Vector3d& v);

inline Eigen::Vector3d middle_of(const ManifoldPoint& p)
{
    return 0.5 * (p.point_a + p.point_b);
}

/// An upper bound of the distance of a point from the hull of these points (at least one): between their middles.
double distance_from_hull(const Eigen::Vector3d& point, std::span<const ManifoldPoint> hull);

/// A bound of the rounding of coordinates of the pair, metres.
double rounding_of(const PlacedSurface& a, const PlacedSurface& b);

} // namespace oncollide
