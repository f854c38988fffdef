#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include <oncollide/base/error.hpp>
#include <oncollide/pipeline/results.hpp>

namespace oncollide {

class World;

/// Finds the points of the last frame in a new one, so that a solver can keep their impulses. Two points of the same
/// two bodies match if their features are equal, and otherwise if they are at most `match_distance` apart in the frame
/// of one of the bodies; their normals may differ by 5 degrees. Verdicts, hashes and manifolds do not depend on this
/// class.
class ONCOLLIDE_API ManifoldTracker {
public:
    static constexpr std::uint32_t none = ~0u;
    struct Update {
        std::vector<std::uint32_t> previous; ///< for each point: its index in the last frame, or none
        std::vector<std::uint64_t> ids;      ///< for each point: kept while the point persists, never used again
        std::vector<std::uint32_t> ended;    ///< indices of points of the last frame that have no successor
    };
    /// @param match_distance  metres, >= 0. Throws Error{usage} otherwise.
    explicit ManifoldTracker(double match_distance = 0.01);
    /// Takes the next frame. The lists must be the manifolds of `pairs`; each pair occurs once, its bodies always in
    /// the same order. Throws Error{usage} for lists of another length.
    const Update& update(const World& world, std::span<const PairOfBodies> pairs, const ManifoldLists& manifolds);

private:
    struct Point {
        FeatureBits feature_a, feature_b;
        Eigen::Vector3d in_a, in_b, normal; ///< in the bodies' frames; the normal in a's
        std::uint64_t id;
    };
    struct PointsOfPair {
        PairOfBodies pair;
        std::uint32_t first, end;
    };
    struct Frame {
        std::vector<Point> points;
        std::vector<PointsOfPair> pairs; ///< sorted
    };
    void match(const PointsOfPair& before, const PointsOfPair& now);

    double match_distance_;
    std::uint64_t next_id_ = 0;
    Frame last_, now_;
    Update update_;
};

} // namespace oncollide
