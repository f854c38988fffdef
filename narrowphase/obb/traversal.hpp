#pragma once
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include <oncollide/narrowphase/obb/box_walk.hpp>
#include <oncollide/narrowphase/obb/obb_tree.hpp>
#include <oncollide/narrowphase/exact/plane_sides.hpp>
#include <oncollide/narrowphase/exact/triangle_tests.hpp>

namespace oncollide {

template <class A, class B>
concept two_meshes = std::is_same_v<A, ObbTree> && std::is_same_v<B, ObbTree>;
template <class A, class B>
using TriangleWalk = BoxWalk<A, B, TriangleTestsOf<A, B>>;
extern template class BoxWalk<ObbTree, ObbTree, TriangleTests>;
extern template class BoxWalk<TerrainTree, ObbTree, TriangleTestsOf<TerrainTree, ObbTree>>;
extern template class BoxWalk<ObbTree, TerrainTree, TriangleTestsOf<ObbTree, TerrainTree>>;
extern template class BoxWalk<TerrainTree, TerrainTree, TriangleTestsOf<TerrainTree, TerrainTree>>;

/// Queries of two meshes or terrains, by walking their hierarchies: the larger box first, the deepest overlap first.
/// Triangles are decided by exact predicates on the file's own coordinates: those of B are moved into A's frame in
/// double, and for the coordinates so rounded "meet" is exact. Touching counts.
///
/// One thread's working memory; others may walk the same trees meanwhile. Distances are metres.
template <class A, class B>
class alignas(128) TraversalOf { // lines of its own: one a thread
public:
    using Place = typename TriangleWalk<A, B>::Place;
    struct Meeting {
        std::optional<TrianglePair> pair; ///< two triangles that meet
        double bound; ///< else at least so far are the meshes apart, as placed: > 0 unless doubles cannot express it
    };
    /// Some two triangles that meet; those of `hint` if they do. Which ones depends on the meshes and poses alone.
    /// Cost: for meshes of 5,000 triangles some 3 microseconds; what the trees grow besides.
    /// @param place  as BoxWalk::meetings()
    Meeting first_meeting(A& a, B& b, const RelativePose& b_to_a, std::optional<TrianglePair> hint = {},
                          std::optional<Place>* place = nullptr);

    struct Contact {
        std::optional<TrianglePair> pair; ///< two triangles that cross, or where none do, two that touch
        double bound;                     ///< as of Meeting
        TriangleContact kind = TriangleContact::separate;
        bool parted = false; ///< touching: a plane was found that has all of A on one closed side and all of B on the
                             ///< other, so they share no inside
    };
    /// Costs more than first_meeting() where they touch: then all triangles that meet are looked at, unless a plane is
    /// seen to part the meshes.
    Contact contact(A& a, B& b, const RelativePose& b_to_a, std::optional<TrianglePair> hint = {},
                    std::optional<Place>* place = nullptr);

    /// All, each once, sorted, to `out`, overwritten.
    void all_meeting(A& a, B& b, const RelativePose& b_to_a, std::vector<TrianglePair>& out);

    /// Of each triangle: bit i for a corner i that is all that it and some triangle of the other mesh have in common.
    struct CommonCorners {
        std::vector<std::uint8_t> of_a, of_b;
    };
    /// As above, but without pairs that were seen to have a corner in common and nothing else: of these only the
    /// corners, as fans of n triangles that touch in a point are n^2 pairs. `corners` is overwritten, too. Of meshes.
    void all_meeting(A& a, B& b, const RelativePose& b_to_a, std::vector<TrianglePair>& out,
                     CommonCorners& corners) requires two_meshes<A, B>;

    /// As BoxWalk::near() and BoxWalk::distance().
    using Nearness = NearBounds<TrianglePair>;
    Nearness near(A& a, B& b, const RelativePose& b_to_a, double clearance, double tolerance,
                  std::optional<TrianglePair> hint = {}, std::optional<Place>* place = nullptr);
    using Distance = DistanceBounds<TrianglePair>;
    Distance distance(A& a, B& b, const RelativePose& b_to_a, double tolerance,
                      double farthest = std::numeric_limits<double>::infinity());

    struct Counts {
        std::uint64_t box_rows = 0;   ///< tests of one box against those of a node
        std::uint64_t triangles = 0;  ///< pairs of triangles tested
        std::uint64_t unsure = 0;     ///< of these, left by the filter to exact arithmetic
        std::uint64_t hints_held = 0; ///< queries that their hint or place decided
    };
    Counts counts() const
    {
        return {walk_.box_rows, walk_.leaves().counts.tested, walk_.leaves().counts.unsure, walk_.hints_held};
    }
    TriangleWalk<A, B>& walk() { return walk_; }
    void reset_counts() { walk_.box_rows = walk_.hints_held = 0, walk_.leaves().counts = {}; }

private:
    template <class Leave>
    void collect(A& a, B& b, const RelativePose& b_to_a, std::vector<TrianglePair>& out, Leave leave);

    using Tests = TriangleTestsOf<A, B>;
    TriangleWalk<A, B> walk_;
    std::array<PlaneSides, 4> planes_; ///< that have triangles which touch on their two sides
};
using Traversal = TraversalOf<ObbTree, ObbTree>;

} // namespace oncollide
