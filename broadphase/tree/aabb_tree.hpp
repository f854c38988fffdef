#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <oncollide/base/error.hpp>
#include <oncollide/base/function_ref.hpp>
#include <oncollide/base/memory/large_vector.hpp>
#include <oncollide/base/simd/prefetch.hpp>
#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/broadphase/segment_line.hpp>
#include <oncollide/broadphase/tree/aabb_order.hpp>
#include <oncollide/broadphase/tree/aabb_tree_kernel.hpp>

namespace oncollide {

/// The filters that forbid some pair of bodies.
struct ForbiddingFilters {
    bool layers = false, groups = false;

    bool any() const { return layers || groups; }
    friend bool operator==(ForbiddingFilters, ForbiddingFilters) = default;
};

/// The group that forbids pairs of the body; mixed_groups: none does.
inline std::uint32_t forbidding_group(std::uint32_t group)
{
    return group == 0 ? mixed_groups : group;
}

/// AABBs in an order that keeps neighbours together, 16 per leaf, under an implicit 16-ary tree of bounds: no pointers,
/// and one or two vector comparisons test a node, stored as columns.
///
/// The order stays while boxes move a little: refit() updates boxes and widens bounds, and degraded() reports when
/// the bounds have become so wide that rebuilding pays off. Boxes are floats relative to the centre of all boxes,
/// rounded outward. 34 bytes per box.
class AabbTree {
public:
    explicit AabbTree(AabbOrder kind) : kind_(kind) {}

    /// Cost: see AabbOrder.
    void build(std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies, double margin, int threads);
    /// Updates the boxes of all bodies. Cost: O(n).
    void refit(std::span<const Aabb> boxes, double margin, int threads);
    /// Updates these bodies to box_of(body), which must be usable. The bounds above them only widen; refit() tightens
    /// them. Cost: O(bodies).
    void refit_bodies(std::span<const std::uint32_t> bodies, FunctionRef<Aabb(std::uint32_t body)> box_of,
                      double margin);
    /// Adds bodies in new leaves at the end. If this needs another level, rebuilds the tree and returns true. Cost
    /// without a rebuild: O(bodies log bodies + nodes).
    bool append(std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies, double margin, int threads);
    /// The same for bodies that are in the tree: they get new slots. Counts as degrading the tree.
    bool reinsert(std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies, double margin, int threads);
    /// Removes bodies; their slots stay empty until the next build(). Cost: O(bodies).
    void erase(std::span<const std::uint32_t> bodies);
    /// Marks as moving the bodies whose state has one of `bits`; pairs of two other bodies are never found. Required
    /// before a search of the whole tree, after build() and append().
    void set_moving(const std::uint8_t* states, std::uint8_t bits);
    /// Lets searches skip two nodes if these filters forbid every pair of their bodies. Forgotten by build().
    void set_filters(const BodyColumns& columns, ForbiddingFilters which);
    /// Adds the filters of a body that is new or whose filters changed. Only after set_filters().
    void add_filters(std::uint32_t body, const BodyColumns& columns);
    void forget_filters();

    /// True if the edges of the leaves have grown by the factor `to` since they were built, so that searches cost
    /// markedly more.
    bool degraded(double to = 1.2) const { return leaf_extent_ > to * built_extent_; }
    bool empty() const { return order_.empty(); }
    std::uint32_t size() const { return static_cast<std::uint32_t>(order_.size()); } ///< slots, padding included
    std::uint32_t bodies() const { return bodies_; }
    std::uint32_t body_at(std::uint32_t place) const
    {
        ONCOLLIDE_ASSERT(place < size());
        return order_[place];
    }
    void prefetch_body_at(std::uint32_t place) const { prefetch(&order_[place]); }
    /// True if `box` does not overlap the bounds of the leaf that holds the body.
    bool outside_leaf(std::uint32_t body, const Aabb& box, double margin) const;
    /// The body must be in the tree.
    std::uint32_t place_of(std::uint32_t body) const
    {
        ONCOLLIDE_ASSERT(body < places_.size() && places_[body] < size());
        return places_[body];
    }
    void prefetch_place_of(std::uint32_t body) const { prefetch(&places_[body]); }
    const AabbTreeView& view() const { return view_; }
    /// Bodies below node `node` of level `level` >= 1.
    std::uint32_t bodies_below(int level, std::uint32_t node) const { return at(level).nodes[node].bodies; }
    /// Volume of one node's bounds, or of all nodes of a level, as of the last complete refit.
    double volume(int level, std::uint32_t node) const { return at(level).nodes[node].volume; }
    double volume(int level) const { return at(level).volume; }
    /// Bounds of the bodies below a node of level `level` >= 1.
    Aabb bounds(int level, std::uint32_t node) const;
    /// The box as the search sees it: lo x y z, hi x y z, grown by margin / 2.
    void round(const Aabb& box, double margin, float out[6]) const;
    /// Sets `line` to the part of a segment that may meet boxes grown by `margin` on all sides; false: no part can.
    bool find_line(const Segment& segment, double margin, SegmentLine& line) const;
    /// True if the box in slot `i` and `b` overlap by more than the rounding, so the exact boxes overlap too. Rounding
    /// moves a coordinate by at most 2^-22 of the largest coordinate; two coordinates and their comparison err by less
    /// than 2^-20.
    bool surely_overlap(std::uint32_t i, const float* b, std::size_t stride = 1) const
    {
        const float slack = farthest_ * 0x1p-20f, *a = corner(i);
        return (a[0] + slack <= b[3 * stride]) & (b[0] + slack <= a[48]) & (a[16] + slack <= b[4 * stride]) &
               (b[stride] + slack <= a[64]) & (a[32] + slack <= b[5 * stride]) & (b[2 * stride] + slack <= a[80]);
    }
    bool surely_overlap(std::uint32_t i, std::uint32_t j) const { return surely_overlap(i, corner(j), 16); }
    /// The box in a slot, as the search sees it: lo x y z, hi x y z.
    void box_at(std::uint32_t place, float box[6]) const
    {
        for (std::size_t c = 0; c < 6; ++c) box[c] = corner(place)[16 * c];
    }
    void prefetch_box_at(std::uint32_t place) const
    {
        for (std::size_t c = 0; c < 6; ++c) prefetch(&corner(place)[16 * c]);
    }
    std::size_t bytes() const;
    /// Returns the first fault of the whole structure as text; empty: it has none. Assertions and tests call it. Cost:
    /// O(n).
    /// @param columns  the columns as of the last change: each body's box is within the box in its slot
    /// @param states  set_moving() was called with these states and bits since the last build() and append(); null: it
    ///                was not
    std::string validate(const BodyColumns& columns, double margin, const std::uint8_t* states,
                         std::uint8_t bits) const;

private:
    struct Node {
        std::uint32_t bodies = 0; ///< number of bodies below
        float volume = 0;
    };
    struct Level {
        LargeVector<float> blocks;         ///< see AabbLevelView
        std::vector<std::uint16_t> moving; ///< by node of the level above: bit k: child k is or holds a moving body
        std::uint32_t count = 0;
        // Columns by node, for levels above 0.
        std::vector<Node> nodes;
        // Empty if unknown.
        std::vector<std::uint32_t> layers, masks; ///< bitwise or over the bodies below
        std::vector<std::uint32_t> groups;        ///< as in AabbLevelView
        double volume = 0;                        ///< volume of all nodes
    };

    const Level& at(int level) const
    {
        ONCOLLIDE_ASSERT(level >= 0 && level < view_.levels);
        return levels_[static_cast<std::size_t>(level)];
    }
    std::string fault_of_slots(const BodyColumns& columns, double margin) const;
    std::string fault_of_level(int level, const BodyColumns& columns) const;
    std::string fault_of_marks(const std::uint8_t* states, std::uint8_t bits) const;
    void extend_levels();
    void extend_filters();
    void bound_from(std::uint32_t place);
    void measure();
    class Taker;
    /// The first coordinate of the box in a slot; the other five follow at distances of 16.
    const float* corner(std::uint32_t place) const
    {
        return view_.level[0].blocks + std::size_t{place / 16} * aabb_block + place % 16;
    }
    static float& coordinate(Level& level, std::uint32_t place, std::size_t c); ///< c: lo x y z, hi x y z
    void bound(int level, std::uint32_t node);
    float volume_of(int level, std::uint32_t node) const;
    double extent_of_leaves() const;

    AabbOrder kind_;
    std::uint32_t bodies_ = 0;
    LargeVector<std::uint32_t> order_;  ///< body by slot
    LargeVector<std::uint32_t> places_; ///< slot by body
    Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
    std::vector<Level> levels_;
    AabbTreeView view_{};
    ForbiddingFilters filters_{};               ///< the known ones
    double leaf_extent_ = 0, built_extent_ = 0; ///< sum of the leaves' edges, now and when built
    float farthest_ = 0;                        ///< upper bound on the magnitude of coordinates
};

/// The implementation for instruction_set().
const AabbTreeKernel& aabb_tree_kernel();

} // namespace oncollide
