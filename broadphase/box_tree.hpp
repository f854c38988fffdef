#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include <oncollide/broadphase/box_tree_kernel.hpp>
#include <oncollide/scenes/aabb.hpp>

namespace oncollide {

/// Boxes in the order of a kd-tree, 16 a leaf, and over them an implicit tree of bounds, 16 children a node: no
/// pointers, every node a row of columns that one or two vector comparisons test.
///
/// The order stays while boxes move a little: refit() takes in new boxes and widens the bounds, and says when these
/// have become so wide that building again pays. Boxes are floats relative to the middle of all, rounded outward.
/// Large boxes among small ones have subtrees of their own: they would widen every node that they are in.
/// 34 bytes a box.
class BoxTree {
public:
    /// Cost: O(n log n), 0.2 microseconds a box of a million.
    void build(std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies, double margin, int threads);
    /// Takes in the boxes of all bodies. Cost: O(n).
    void refit(std::span<const Aabb> boxes, double margin, int threads);
    /// Takes in the boxes of these bodies only. The bounds above them are widened, not tightened: that waits for
    /// refit(). Cost: O(bodies).
    void refit_bodies(std::span<const Aabb> boxes, double margin, std::span<const std::uint32_t> bodies);
    /// Marks which bodies move; pairs of two that do not are never found. Before a search, after build().
    void set_moving(std::span<const std::uint8_t> is_static);

    /// Have the leaves grown by so much, since they were built, that a search costs markedly more?
    bool worn() const { return leaf_extent_ > 1.2 * built_extent_; }
    std::uint32_t size() const { return static_cast<std::uint32_t>(order_.size()); } ///< places, padding included
    std::uint32_t body_at(std::uint32_t place) const { return order_[place]; }
    std::uint32_t place_of(std::uint32_t body) const { return places_[body]; }
    static constexpr std::uint32_t nobody = ~0u; ///< at places of padding
    const BoxTreeView& view() const { return view_; }
    /// Do the boxes at two places overlap by more than rounding could account for? A coordinate is rounded by at most
    /// 2^-22 of the largest; two of them, and their comparison, by less than 2^-20.
    bool surely_overlap(std::uint32_t i, std::uint32_t j) const
    {
        const float slack = farthest_ * 0x1p-20f, *a = corner(i), *b = corner(j);
        return (a[0] + slack <= b[48]) & (b[0] + slack <= a[48]) & (a[16] + slack <= b[64]) & (b[16] + slack <= a[64]) &
               (a[32] + slack <= b[80]) & (b[32] + slack <= a[80]);
    }
    /// The box at a place, as the search sees it: lo x y z, hi x y z.
    void box_at(std::uint32_t place, float box[6]) const
    {
        for (std::size_t c = 0; c < 6; ++c) box[c] = corner(place)[16 * c];
    }
    std::size_t bytes() const;

private:
    struct Level {
        std::vector<float> blocks;         ///< see BoxLevelView
        std::vector<std::uint16_t> moving; ///< by node of the level above
        std::uint32_t count = 0;
    };
    struct Item { ///< a body while it is put in order
        float centre[3];
        std::uint32_t body;
    };

    void order_bodies(std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies, int threads);
    std::size_t split_once(std::size_t begin, std::size_t end);
    void split(std::size_t begin, std::size_t end);
    void make_levels();
    class Taker;
    /// The first coordinate of the box at a place; the other five follow 16 apart.
    const float* corner(std::uint32_t place) const
    {
        return view_.level[0].blocks + std::size_t{place / 16} * box_block + place % 16;
    }
    static float& coordinate(Level& level, std::uint32_t place, std::size_t c); ///< c: lo x y z, hi x y z
    void bound(int level, std::uint32_t node);
    double extent_of_leaves() const;

    std::vector<std::uint32_t> order_;  ///< body by place
    std::vector<std::uint32_t> places_; ///< place by body
    std::vector<Item> items_;           ///< scratch of build, given back after it
    Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
    std::vector<Level> levels_;
    BoxTreeView view_{};
    double leaf_extent_ = 0, built_extent_ = 0; ///< sum of the leaves' edges
    float farthest_ = 0;                        ///< largest coordinate, at least
};

/// The kernel of instruction_set().
const BoxTreeKernel& box_tree_kernel();

} // namespace oncollide
