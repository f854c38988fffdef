// Features of two surfaces that are near each other, and regions of them.
#pragma once
#include <vector>

#include <oncollide/narrowphase/pairs/manifolds/placed_surface.hpp>

namespace oncollide {

/// Two near features, in the frame of the pair.
struct NearPair {
    FeatureBits a, b;
    std::uint32_t triangle_a, triangle_b; ///< a triangle of each feature
    std::uint8_t corners_a, corners_b;    ///< bits of the triangles' corners that span the features
    Eigen::Vector3d point_a, point_b;
    double distance;
};

/// All pairs within dhat, each once, sorted by (a, b). Distances err by at most `rounding`, which is added to dhat.
/// @param minima_only  leaves out vertices and edges that do not stick out, at which no distance has a local minimum
///                     unless it has one beside them, too
std::vector<NearPair> near_pairs(PairWorker& worker, const PlacedSurface& a, const PlacedSurface& b,
                                 const RelativePose& b_to_a, double dhat, double rounding, bool minima_only);

/// Appends regions of surfaces at most options.margin apart that do not meet.
void add_near_regions(PairWorker& worker, const PairTask& task, const PlacedSurface& a, const PlacedSurface& b,
                      const RelativePose& b_to_a, const ManifoldOptions& options, Manifold& manifold);

} // namespace oncollide
