#pragma once
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include <oncollide/base/function_ref.hpp>
#include <oncollide/narrowphase/exact/plane_sides.hpp>
#include <oncollide/narrowphase/obb/obb_tree.hpp>
#include <oncollide/narrowphase/walks/box_walk.hpp>
#include <oncollide/narrowphase/walks/triangle_tests.hpp>

namespace oncollide {

template <class A, class B>
concept two_meshes = std::is_same_v<A, ObbTree> && std::is_same_v<B, ObbTree>;
template <class A, class B>
using TriangleWalk = BoxWalk<A, B, TriangleTestsOf<A, B>>;
extern template class BoxWalk<ObbTree, ObbTree, TriangleTests>;
extern template class BoxWalk<TerrainTree, ObbTree, TriangleTestsOf<TerrainTree, ObbTree>>;
extern template class BoxWalk<ObbTree, TerrainTree, TriangleTestsOf<ObbTree, TerrainTree>>;
extern template class BoxWalk<TerrainTree, TerrainTree, TriangleTestsOf<TerrainTree, TerrainTree>>;

/// Queries of two meshes or terrains, by traversing their hierarchies.
/// Exact predicates decide triangles on the file's own coordinates: B's are moved into A's frame in double, and for the
/// coordinates so rounded "meet" is exact. Touching counts.
///
/// One thread's working memory; other threads may traverse the same trees meanwhile. Distances are metres.
template <class A, class B>
class alignas(128) TraversalOf { // own cache lines: one object per thread
public:
    using Place = typename TriangleWalk<A, B>::Place;
    struct Meeting {
        std::optional<TrianglePair> pair; ///< two triangles that meet
        double bound; ///< if none meet, a lower bound of the distance: > 0 unless doubles cannot express it
    };
    /// Finds two triangles that meet; the pair of `hint` if it meets. The pair depends on the meshes, the poses,
    /// `hint` and `place` alone. Cost: about 3 microseconds for meshes of 5,000 triangles, and the growth of the trees.
    /// @param place  as in BoxWalk::meetings()
    Meeting first_meeting(A& a, B& b, const RelativePose& b_to_a, std::optional<TrianglePair> hint = {},
                          std::optional<Place>* place = nullptr);

    struct Contact {
        std::optional<TrianglePair> pair; ///< two triangles that cross, or if none cross, two that touch
        double bound;                     ///< as in Meeting
        TriangleContact kind = TriangleContact::separate;
        bool parted = false; ///< touching: a plane was found that has all of A on one closed side and all of B on the
                             ///< other, so their insides do not overlap
    };
    /// Costs more than first_meeting() for meshes that touch: it then tests all triangles that meet, unless it finds a
    /// plane that separates the meshes.
    /// @param overlap  called for some of the pairs that touch; true if it found a common point of the meshes' insides:
    ///                 they then count as crossing
    Contact contact(
        A& a, B& b, const RelativePose& b_to_a, std::optional<TrianglePair> hint = {},
        std::optional<Place>* place = nullptr,
        FunctionRef<bool(TrianglePair)> overlap = [](TrianglePair) { return false; });

    /// Writes all pairs that meet to `out`, each once, sorted; overwrites `out`.
    void all_meeting(A& a, B& b, const RelativePose& b_to_a, std::vector<TrianglePair>& out);

    /// Writes all pairs at most `clearance` apart to `out`, and perhaps others; each once, in any order; overwrites
    /// `out`.
    /// @param meeting  overwritten with the pairs that meet, as `out` of all_meeting(); null: not needed
    void all_near(A& a, B& b, const RelativePose& b_to_a, double clearance, std::vector<TrianglePair>& out,
                  std::vector<TrianglePair>* meeting = nullptr);

    /// For each triangle, bit i is set if it and some triangle of the other mesh have only its corner i in common.
    struct CommonCorners {
        std::vector<std::uint8_t> of_a, of_b;
    };
    /// As above, without pairs that were found to have only a corner in common: only their corners are stored, as two
    /// fans of n triangles that touch in a point give n^2 pairs. Overwrites `corners`, too. Meshes only.
    void all_meeting(A& a, B& b, const RelativePose& b_to_a, std::vector<TrianglePair>& out,
                     CommonCorners& corners) requires two_meshes<A, B>;

    /// As BoxWalk::near() and BoxWalk::distance().
    using Nearness = NearBounds<TrianglePair>;
    Nearness near(A& a, B& b, const RelativePose& b_to_a, double clearance, double tolerance,
                  std::optional<TrianglePair> hint = {}, std::optional<Place>* place = nullptr);
    using Distance = DistanceBounds<TrianglePair>;
    Distance distance(A& a, B& b, const RelativePose& b_to_a, double tolerance,
                      double cutoff = std::numeric_limits<double>::infinity());

    struct Counts {
        std::uint64_t box_rows = 0;   ///< tests of one box against all boxes of a node
        std::uint64_t triangles = 0;  ///< pairs of triangles tested
        std::uint64_t unsure = 0;     ///< pairs that the filter left to exact arithmetic
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
    PartingPlanes planes_;
};
using Traversal = TraversalOf<ObbTree, ObbTree>;

} // namespace oncollide
