#pragma once
#include <atomic>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <oncollide/base/simd/prefetch.hpp>
#include <oncollide/base/threads/lock_order.hpp>
#include <oncollide/narrowphase/obb/node_lines.hpp>
#include <oncollide/narrowphase/obb/obb_tree.hpp>
#include <oncollide/narrowphase/rays/tree/ray_node.hpp>

namespace oncollide {

/// Axis-aligned boxes and quantised triangles for segments, grown where segments go: an oriented box takes five times
/// as long to test against a line. The upper levels have the triangles of the ObbTree's boxes; a box of at most 128
/// triangles has one node over rows of eight. Many segments may grow the tree concurrently.
///
/// Source: leaves with quantised triangles beside wide nodes, as in Benthin et al., "Compressed-leaf bounding volume
/// hierarchies", HPG 2018.
class RayTree {
public:
    /// Keeps a reference to the tree, which must be in memory and must not deform. Cost: one node.
    explicit RayTree(ObbTree& tree);
    ~RayTree();
    RayTree(const RayTree&) = delete;
    RayTree& operator=(const RayTree&) = delete;

    /// A node, or one or two rows of triangles.
    using Ref = std::uint32_t;
    Ref root() const { return root_; }
    static constexpr bool is_rows(Ref ref) { return ref >> 31; }
    static constexpr unsigned rows_in(Ref ref) { return 1 + (ref >> 30 & 1); }

    const ObbTree& tree() const { return tree_; }
    /// Bounds the rounding of coordinates relative to the centre, metres.
    double rounding() const { return rounding_; }
    const RayNode& node(Ref ref) const { return node_at(ref); }
    const RayTriangles* rows(Ref ref) const { return reinterpret_cast<const RayTriangles*>(&line(ref & place_bits)); }
    /// The child of box k, grown if it does not exist yet.
    Ref child(Ref parent, unsigned k)
    {
        const Ref child = grown(parent, k);
        return child ? child : grow(parent, k);
    }
    void prefetch_child(Ref parent, unsigned k) const
    {
        const Ref child = grown(parent, k);
        oncollide::prefetch(&line(child & place_bits),
                            is_rows(child) ? rows_in(child) * sizeof(RayTriangles) : sizeof(RayNode));
    }
    std::size_t bytes() const { return bytes_.load(std::memory_order_relaxed); }
    /// The first fault of the grown part as text; empty: it has none. Not while it grows.
    std::string validate() const;

private:
    static constexpr Ref rows_bit = 1u << 31, two_bit = 1u << 30, place_bits = two_bit - 1;
    static constexpr std::uint32_t row = 8, most_in_node = 16 * row; ///< triangles

    RayNode& node_at(Ref ref) const { return reinterpret_cast<RayNode&>(line(ref)); }
    NodeLine& line(Ref place) const { return blocks_[place / lines_per_block][place % lines_per_block]; }
    Ref grown(Ref parent, unsigned k) const
    {
        return std::atomic_ref(node_at(parent).child[k]).load(std::memory_order_acquire);
    }
    Ref grow(Ref parent, unsigned k);
    Ref add_lines(std::uint32_t count);
    Ref add_node();
    Ref node_over(ObbTree::Node boxes);
    struct Item;
    Ref part(std::span<Item> items);
    void divide(RayNode& to, unsigned& lanes, std::span<Item> items, std::uint32_t most, unsigned into);
    Ref add_rows(std::span<const Item> items);
    std::span<Item> items_of(std::uint32_t begin, std::uint32_t count);
    void set_bounds(RayNode& to, unsigned k, const Aabb& box) const;

    ObbTree& tree_;
    const double rounding_;
    Ref root_;
    std::vector<NodeLine*> blocks_; ///< for all possible lines; null until used
    std::uint32_t lines_ = 0;
    std::atomic<std::size_t> bytes_ = 0;
    OrderedMutex<LockRank::ray_tree> growing_;
    std::vector<std::uint32_t> numbers_; ///< while it grows
    std::vector<Item> items_;            ///< while it grows
};

} // namespace oncollide
