#pragma once
#include <array>
#include <compare>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include <oncollide/narrowphase/boxes/opened_tree.hpp>
#include <oncollide/narrowphase/exact/plane_sides.hpp>
#include <oncollide/narrowphase/exact/triangle_test.hpp>
#include <oncollide/narrowphase/relative_pose.hpp>

namespace oncollide {

/// Triangles a and b of two meshes, by number.
struct TrianglePair {
    std::uint32_t a, b;

    friend auto operator<=>(const TrianglePair&, const TrianglePair&) = default;
};

/// Questions about two meshes, answered by walking their trees of oriented boxes: the larger box first, the deepest
/// overlap first. Triangles are decided by exact predicates on the file's own coordinates: those of B are moved into
/// A's frame in double, and for the coordinates so rounded "meet" is exact. Touching counts.
///
/// One thread's working memory; others may walk the same trees meanwhile. Distances are metres.
class alignas(128) Traversal { // lines of its own: one a thread
public:
    struct Meeting {
        std::optional<TrianglePair> pair; ///< two triangles that meet
        double bound; ///< else at least so far are the meshes apart, as placed: > 0 unless doubles cannot express it
    };
    /// Some two triangles that meet; those of `hint` if they do. Which ones depends on the meshes and poses alone.
    /// Cost: for meshes of 5,000 triangles some 3 microseconds; what the trees grow besides.
    Meeting first_meeting(ObbTree& a, ObbTree& b, const RelativePose& b_to_a, std::optional<TrianglePair> hint = {});

    struct Contact {
        std::optional<TrianglePair> pair; ///< two triangles that cross, or where none do, two that touch
        double bound;                     ///< as of Meeting
        TriangleContact kind = TriangleContact::separate;
        bool parted = false; ///< touching: a plane was found that has all of A on one closed side and all of B on the
                             ///< other, so they share no inside
    };
    /// Costs more than first_meeting() where they touch: then all triangles that meet are looked at, unless a plane is
    /// seen to part the meshes.
    Contact contact(ObbTree& a, ObbTree& b, const RelativePose& b_to_a, std::optional<TrianglePair> hint = {});

    /// All, each once, sorted, to `out`, overwritten.
    void all_meeting(ObbTree& a, ObbTree& b, const RelativePose& b_to_a, std::vector<TrianglePair>& out);

    struct Nearness {
        bool near;
        double bound; ///< near: the distance is at most this, clearance + tolerance (or, if that is less, + rounding);
                      ///< else at least this, and no less than the clearance; > 0 as of Meeting
        std::optional<TrianglePair> meeting; ///< two triangles that meet, where such were found
    };
    /// Are they within `clearance`? Meshes farther apart than that, but not than clearance + tolerance, may be called
    /// near. The answer does not depend on `hint`.
    Nearness near(ObbTree& a, ObbTree& b, const RelativePose& b_to_a, double clearance, double tolerance,
                  std::optional<TrianglePair> hint = {});

    struct Distance {
        double lower, upper;                 ///< of the meshes; both 0 where they were seen to meet
        std::optional<TrianglePair> nearest; ///< two triangles that are `upper` apart, or that meet
    };
    /// Bounds on the distance, at most `tolerance` and rounding apart; nearest boxes first. Of meshes that are farther
    /// apart than `farthest` only a lower bound above that is found; the upper one is then infinite, else never.
    Distance distance(ObbTree& a, ObbTree& b, const RelativePose& b_to_a, double tolerance,
                      double farthest = std::numeric_limits<double>::infinity());

    struct Counts {
        std::uint64_t box_rows = 0;  ///< tests of one box against those of a node
        std::uint64_t triangles = 0; ///< pairs of triangles tested
        std::uint64_t unsure = 0;    ///< of these, left by the filter to exact arithmetic
    };
    const Counts& counts() const { return counts_; }
    void reset_counts() { counts_ = {}; }

private:
    /// Where a walk stands: a box of an open node on both sides.
    struct Entry {
        std::uint32_t a, b; ///< slots
        std::uint8_t lane_a, lane_b;
        float gap;
    };
    struct Query;

    void start(const Query& query);
    bool both_leaves(const Entry& e) const;
    template <class Visit>
    bool each_pair(const Entry& e, Visit visit) const;
    template <bool far>
    unsigned open(const Entry& e, float reach);
    template <class TakeLeaves>
    void walk(const Query& query, float reach, TakeLeaves take_leaves);
    template <class Found>
    bool test_waiting(const Query& query, Found found);
    template <class Found>
    bool test_if_enough(const Query& query, std::size_t& batch, Found found);
    template <class Found, class Leave>
    double meetings(const Query& query, std::optional<TrianglePair> hint, Found found, Leave leave);
    double least_gap(const Query& query);

    OpenedTree a_, b_;
    std::vector<Entry> stack_; ///< its first top_ are in use
    std::size_t top_ = 0;
    std::vector<TrianglePair> waiting_;        ///< pairs of triangles to be tested together
    std::vector<TrianglePair> barely_apart_;   ///< pairs that exact arithmetic alone could part
    alignas(32) float nearest_[8];             ///< least gaps of boxes that were left
    alignas(64) double nearest_triangles2_[8]; ///< least squared gaps of triangles that were found apart
    std::array<PlaneSides, 4> planes_;         ///< that have triangles which touch on their two sides
    Counts counts_;
};

} // namespace oncollide
