// Features of two surfaces that are near each other, and regions of them.
#pragma once
#include <vector>

#include <oncollide/narrowphase/pairs/manifolds/placed_surface.hpp>

namespace oncollide {

struct ManifoldMemory;

/// Two near features, in the frame of the pair.
struct NearPair {
    FeatureBits a, b;
    std::uint32_t triangle_a, triangle_b; ///< a triangle of each feature
    std::uint8_t corners_a, corners_b;    ///< bits of the triangles' corners that span the features
    Eigen::Vector3d point_a, point_b;
    double distance;

    bool has_face() const { return corners_a == 7 || corners_b == 7; }
};

/// Leaves out vertices and edges that do not stick out, at which no distance has a local minimum unless it has one
/// beside them, too; and points that are at most `rounding` apart, or behind a surface.
struct NearFilter {
    double rounding; ///< negative: only the first

    /// @param out_a,out_b  unit normals of the pair's triangles; 0 without area
    bool keeps(const NearPair& pair, const Eigen::Vector3d& out_a, const Eigen::Vector3d& out_b) const
    {
        if (rounding < 0) return true;
        if (!(pair.distance > rounding)) return false;
        const Eigen::Vector3d way = pair.point_b - pair.point_a; // out of a, into b
        const double least = -0.5 * pair.distance;
        return way.dot(out_a) > (pair.corners_a == 7 ? 0 : least) &&
               -way.dot(out_b) > (pair.corners_b == 7 ? 0 : least);
    }
};

/// Finds all pairs within dhat, each once, sorted by (a, b). Distances err by at most `rounding`, which is added to
/// dhat.
/// @param filter  null: keeps all
void near_pairs(PairWorker& worker, const PlacedSurface& a, const PlacedSurface& b, const RelativePose& b_to_a,
                double dhat, double rounding, const NearFilter* filter, std::vector<NearPair>& found);

/// Appends regions of surfaces at most options.margin apart that do not meet.
void add_near_regions(PairWorker& worker, ManifoldMemory& memory, const PairTask& task, const PlacedSurface& a,
                      const PlacedSurface& b, const RelativePose& b_to_a, const ManifoldOptions& options,
                      Manifold& manifold);

} // namespace oncollide
