#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include <oncollide/base/function_ref.hpp>
#include <oncollide/base/large_vector.hpp>
#include <oncollide/base/prefetch.hpp>
#include <oncollide/broadphase/box_order.hpp>
#include <oncollide/broadphase/box_tree_kernel.hpp>
#include <oncollide/broadphase/broad_phase.hpp>

namespace oncollide {

/// Boxes in an order that keeps neighbours together, 16 per leaf, and over them an implicit tree of bounds, 16 children
/// per node: no pointers, every node a row of columns that one or two vector comparisons test.
///
/// The order stays while boxes move a little: refit() takes in new boxes and widens the bounds, and degraded() says
/// when these have become so wide that building again pays. Boxes are floats relative to the middle of all, rounded
/// outward. 34 bytes per box.
class BoxTree {
public:
    explicit BoxTree(BoxOrder kind) : kind_(kind) {}

    /// Cost: see BoxOrder.
    void build(std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies, double margin, int threads);
    /// Takes in the boxes of all bodies. Cost: O(n).
    void refit(std::span<const Aabb> boxes, double margin, int threads);
    /// Takes in box_of(body) for these bodies only, which must be usable. The bounds above them are widened, not
    /// tightened: that waits for refit(). Cost: O(bodies).
    void refit_bodies(std::span<const std::uint32_t> bodies, FunctionRef<Aabb(std::uint32_t body)> box_of,
                      double margin);
    /// Adds bodies in leaves of their own at the end. Cost: O(bodies log bodies). Where the tree gets a level more by
    /// it, it is built anew: then returns true.
    bool append(std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies, double margin, int threads);
    /// Takes bodies out; their places stay empty until the next build(). Cost: O(bodies).
    void erase(std::span<const std::uint32_t> bodies);
    /// Marks which bodies move, those whose state has one of `bits`; pairs of two that do not are never found. Needed
    /// before a search of the whole tree, after build() and append().
    void set_moving(const std::uint8_t* states, std::uint8_t bits);
    /// Lets a search leave out pairs of nodes whose layers do not meet. Forgotten by build().
    void set_layers(const BodyColumns& columns);
    /// Takes in the layers of a body that is new or has other ones. Only after set_layers().
    void add_layers(std::uint32_t body, const BodyColumns& columns);
    void forget_layers();

    /// Have the leaves grown by so much, since they were built, that a search costs markedly more?
    bool degraded(double to = 1.2) const { return leaf_extent_ > to * built_extent_; }
    bool empty() const { return order_.empty(); }
    std::uint32_t size() const { return static_cast<std::uint32_t>(order_.size()); } ///< places, padding included
    std::uint32_t bodies() const { return bodies_; }
    std::uint32_t body_at(std::uint32_t place) const { return order_[place]; }
    void prefetch_body_at(std::uint32_t place) const { prefetch(&order_[place]); }
    std::uint32_t place_of(std::uint32_t body) const { return places_[body]; }
    void prefetch_place_of(std::uint32_t body) const { prefetch(&places_[body]); }
    const BoxTreeView& view() const { return view_; }
    /// Bodies below node `node` of level `level` >= 1.
    std::uint32_t bodies_below(int level, std::uint32_t node) const { return at(level).nodes[node].bodies; }
    /// Volume of a node's bounds, and of all nodes of a level, when they were last refitted as a whole.
    double volume(int level, std::uint32_t node) const { return at(level).nodes[node].volume; }
    double volume(int level) const { return at(level).volume; }
    /// What bounds the bodies below a node of a level above the boxes themselves.
    Aabb bounds(int level, std::uint32_t node) const;
    /// A box as the search would see it: lo x y z, hi x y z, grown by margin / 2.
    void round(const Aabb& box, double margin, float out[6]) const;
    /// Does the box at place `i` overlap `b` by more than rounding could account for? A coordinate is rounded by at
    /// most 2^-22 of the largest; two of them, and their comparison, by less than 2^-20.
    bool surely_overlap(std::uint32_t i, const float* b, std::size_t stride = 1) const
    {
        const float slack = farthest_ * 0x1p-20f, *a = corner(i);
        return (a[0] + slack <= b[3 * stride]) & (b[0] + slack <= a[48]) & (a[16] + slack <= b[4 * stride]) &
               (b[stride] + slack <= a[64]) & (a[32] + slack <= b[5 * stride]) & (b[2 * stride] + slack <= a[80]);
    }
    bool surely_overlap(std::uint32_t i, std::uint32_t j) const { return surely_overlap(i, corner(j), 16); }
    /// The box at a place, as the search sees it: lo x y z, hi x y z.
    void box_at(std::uint32_t place, float box[6]) const
    {
        for (std::size_t c = 0; c < 6; ++c) box[c] = corner(place)[16 * c];
    }
    void prefetch_box_at(std::uint32_t place) const
    {
        for (std::size_t c = 0; c < 6; ++c) prefetch(&corner(place)[16 * c]);
    }
    std::size_t bytes() const;

private:
    struct Node {
        std::uint32_t bodies = 0; ///< below it
        float volume = 0;
    };
    struct Level {
        LargeVector<float> blocks;         ///< see BoxLevelView
        std::vector<std::uint16_t> moving; ///< by node of the level above
        std::uint32_t count = 0;
        // Of levels above the boxes themselves, by node:
        std::vector<Node> nodes;
        std::vector<std::uint32_t> layers, masks; ///< of the bodies below, or-ed; empty when unknown
        double volume = 0;                        ///< of all
    };

    const Level& at(int level) const { return levels_[static_cast<std::size_t>(level)]; }
    void extend_levels();
    void extend_layers();
    void bound_from(std::uint32_t place);
    void measure();
    class Taker;
    /// The first coordinate of the box at a place; the other five follow 16 apart.
    const float* corner(std::uint32_t place) const
    {
        return view_.level[0].blocks + std::size_t{place / 16} * box_block + place % 16;
    }
    static float& coordinate(Level& level, std::uint32_t place, std::size_t c); ///< c: lo x y z, hi x y z
    void bound(int level, std::uint32_t node);
    float volume_of(int level, std::uint32_t node) const;
    double extent_of_leaves() const;

    BoxOrder kind_;
    std::uint32_t bodies_ = 0;
    LargeVector<std::uint32_t> order_;  ///< body by place
    LargeVector<std::uint32_t> places_; ///< place by body
    Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
    std::vector<Level> levels_;
    BoxTreeView view_{};
    bool layers_known_ = false;
    double leaf_extent_ = 0, built_extent_ = 0; ///< sum of the leaves' edges
    float farthest_ = 0;                        ///< largest coordinate, at least
};

/// The kernel of instruction_set().
const BoxTreeKernel& box_tree_kernel();

} // namespace oncollide
