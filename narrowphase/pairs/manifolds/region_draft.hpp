// A region before its points are chosen.
#pragma once
#include <limits>
#include <vector>

#include <oncollide/narrowphase/finding.hpp>
#include <oncollide/narrowphase/pairs/manifolds/near_pairs.hpp>
#include <oncollide/narrowphase/pairs/manifolds/overlap_patches.hpp>
#include <oncollide/narrowphase/rays/segment_walk.hpp>

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
    /// The normal of the faces at the point, from a to b; 0: not known. The own face alone counts until the opposite
    /// one is found.
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
};

constexpr double facing_cosine = 0.9396926; ///< of 20 degrees, by which normals of opposite faces differ at most

/// The normal across two faces, given by their normals from a to b, if they are opposite each other; else 0.
inline Eigen::Vector3d normal_across(const Eigen::Vector3d& of_a, const Eigen::Vector3d& of_b)
{
    return of_a.dot(of_b) >= facing_cosine ? Eigen::Vector3d((of_a + of_b).normalized())
                                           : Eigen::Vector3d(Eigen::Vector3d::Zero());
}

/// In the frame of the pair.
struct RegionDraft {
    ManifoldRegion region{};
    std::vector<ManifoldCandidate> candidates;                              ///< each feature, or pair of features, once
    std::vector<Eigen::Vector3d> contacts;                                  ///< exact contacts of the region
    std::vector<std::pair<std::uint32_t, TrianglePoints>> faces_a, faces_b; ///< where opposite points are, by triangle
    double rounding = 0;                                                    ///< of positions, metres
    double least_depth = 0; ///< shallower points are dropped if others are left
    bool curved = false;    ///< as on a thread: the normal of the region is none of a point

    void clear();
    /// Adds a candidate of both bodies unless one of these features is there.
    void add_shared(const ManifoldCandidate& candidate);

private:
    KeyNumbers shared_; ///< for pairs of features: the candidate
    std::vector<std::uint32_t> candidate_of_;
};

/// Chooses the points among a region's candidates. Keeps its memory.
class PointChoice {
public:
    /// Indices of the candidates to keep, the deepest first.
    const std::vector<std::uint32_t>& choose(const std::vector<ManifoldCandidate>& all, const Eigen::Vector3d& normal,
                                             std::size_t most);

private:
    void take(auto value, double least, double tie);
    void find_edges();

    const std::vector<ManifoldCandidate>* all_ = nullptr;
    std::vector<Eigen::Vector2d> flat_; ///< across the normal
    std::vector<double> values_;
    std::vector<std::uint32_t> kept_;
    std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> edges_;
    double size_ = 0;
};

/// Faces that lines in one direction cross outward, as seen from the body that they bound. The depth and two
/// barycentric coordinates of where such a line through p crosses a face's plane are linear in p - origin.
struct FacesAhead {
    struct Face {
        Eigen::Vector3d depth, second, third;
        double depth_0, second_0, third_0;
        double error; ///< of the depth, for positions that err by 1
        std::uint32_t triangle;
    };
    Eigen::Vector3d origin;
    std::vector<Face> faces;

    void set(const std::vector<std::pair<std::uint32_t, TrianglePoints>>& all, const Eigen::Vector3d& direction);
    /// The nearest of the faces that the line through p crosses; null: none.
    const Face* nearest(const Eigen::Vector3d& p, double& depth) const;
};

/// One thread's working memory for manifolds, kept from pair to pair.
struct ManifoldMemory {
    std::vector<TrianglePair> meeting, near_triangles;
    NearSearch near_search;
    std::vector<NearPair> near;
    OverlapPatches overlap;
    RegionDraft draft;
    PointChoice choice;
    FacesAhead ahead_a, ahead_b;
    /// Numbers of patches of a, of patches of b, and of points of the curve, by lump: lump i begins at offsets[i].
    std::array<std::vector<std::uint32_t>, 3> order, offsets;
    std::array<std::vector<std::uint32_t>, 2> facing;                 ///< for each patch: its direction in the lump
    std::vector<std::array<std::vector<std::uint32_t>, 3>> of_facing; ///< the same numbers, by direction of a lump
    std::vector<std::uint32_t> lump_of;
    std::vector<std::pair<double, std::uint32_t>> by_area;
    KeyNumbers vertices;
    std::vector<bool> done; ///< lumps that have regions
    SegmentWalk<ObbTree> ways_out;
    SegmentWalk<TerrainTree> ways_out_of_terrain;
};

/// Chooses the points, completes the region, and appends both. Drops the draft if it has no point.
void finish(ManifoldMemory& memory, const PlacedSurface& a, const PlacedSurface& b, const ManifoldOptions& options,
            Manifold& manifold);

/// How many regions a pair may have so that each can keep all its points.
std::size_t most_regions(const ManifoldOptions& options);

/// Appends the regions of all lumps of memory.overlap whose common volume is not rounding alone; sets memory.done for
/// these.
void add_crossing_regions(ManifoldMemory& memory, const PlacedSurface& a, const PlacedSurface& b,
                          const ManifoldOptions& options, Manifold& manifold);

/// Appends regions of pairs of triangles that meet without a common volume.
void add_touching_regions(ManifoldMemory& memory, std::span<const TrianglePair> pairs, const PlacedSurface& a,
                          const PlacedSurface& b, const ManifoldOptions& options, Manifold& manifold);

/// The support point of a round solid along a direction (unit, frame of the solid), and other points of its surface on
/// which the solid may lie: ends of a line, corners of a disc.
std::vector<Eigen::Vector3d> support_points(const Convex& solid, const Eigen::Vector3d& direction);

/// The angle between directions, within rounding; pi if a vector has no length.
double angle_between(const Eigen::Vector3d& u, const Eigen::Vector3d& v);

inline Eigen::Vector3d middle_of(const ManifoldPoint& p)
{
    return 0.5 * (p.point_a + p.point_b);
}

/// The hull of the middles of points, for distances.
class PointHull {
public:
    explicit PointHull(std::span<const ManifoldPoint> points); ///< at least one
    /// An upper bound of the squared distance; may stop at any value of at most `enough`.
    double distance2(const Eigen::Vector3d& point, double enough = 0) const;

private:
    struct Side {
        Eigen::Vector3d from, way;
        double inverse; ///< 1 / |way|^2; 0 for a point
    };
    struct Face {
        Eigen::Vector3d normal; ///< unit
        std::array<Eigen::Vector3d, 3> inward;
        std::array<double, 3> least;
        double height;
    };
    std::vector<Eigen::Vector3d> points_;
    std::vector<Side> sides_;
    std::vector<Face> faces_;
};

/// A bound of the rounding of coordinates of the pair, metres.
double rounding_of(const PlacedSurface& a, const PlacedSurface& b);

} // namespace oncollide
