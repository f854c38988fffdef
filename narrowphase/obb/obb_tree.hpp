#pragma once
#include <atomic>
#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <oncollide/base/memory/large_vector.hpp>
#include <oncollide/base/simd/prefetch.hpp>
#include <oncollide/base/threads/lock_order.hpp>
#include <oncollide/broadphase/segment_line.hpp>
#include <oncollide/narrowphase/obb/fits/grid_split.hpp>
#include <oncollide/narrowphase/obb/hierarchy.hpp>
#include <oncollide/narrowphase/obb/mesh_chunks.hpp>
#include <oncollide/narrowphase/obb/tree_growth.hpp>
#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// Nodes and bytes of all OBB trees together. The trees keep it up to date.
struct BoxTotals {
    std::atomic<std::uint64_t> nodes = 0;
    std::atomic<std::size_t> bytes = 0;
};

/// The OBB tree of one mesh: a BoxHierarchy with up to eight boxes per node, grown on demand. A box gets its child node
/// when a traversal first opens it, so a scene pays only for the parts of its meshes that come close to others.
///
/// The triangles of a box are split three times. Each split minimises the sum over both sides of box area times number
/// of triangles, with at least two fifths of the triangles on each side, so the tree is at most 0.46 log2(n) + 3 nodes
/// deep. A node depends on the mesh alone, not on the order of traversals. Traversals may grow the tree concurrently.
///
/// If the vertices of the mesh move (deform()), the nodes keep their triangles, and the nodes that a traversal opens
/// get boxes that fit again. Which triangles meet does not depend on how the tree divides them.
class ObbTree final : public HeldChunks {
public:
    /// Keeps references to the mesh and to the totals. Cost: 5 ns per triangle; the first traversal costs about 50.
    explicit ObbTree(const Mesh& mesh, BoxTotals* totals = nullptr);
    /// The same tree for a cooked mesh, except that triangles have other numbers (see source()). The file stores its
    /// upper levels. Chunks of triangles are read when a traversal first reaches them: open() and child() then throw
    /// ChunkFault if that fails, which ends the traversal. Cost: reading the upper levels.
    ObbTree(std::shared_ptr<const CookedMesh> mesh, ChunkBudget& budget);
    ~ObbTree() override;
    ObbTree(const ObbTree&) = delete;
    ObbTree& operator=(const ObbTree&) = delete;

    using Node = std::uint32_t;
    using Primitive = std::uint32_t; ///< a triangle, by its number in the mesh

    /// Boxes and nodes are relative to this point of the mesh's frame.
    const Eigen::Vector3d& centre() const { return centre_; }
    /// The bounds in the mesh's frame.
    const Aabb& bounds() const { return chunked_ ? chunked_->mesh().bounds() : mesh_->bounds; }
    double radius() const { return radius_; } ///< upper bound of the distance of the triangles' corners from the centre

    /// A node whose only box is the box of the whole mesh.
    static constexpr Node root = 0;
    /// The node below the root; the root if it has none.
    Node below_root() { return node(root).leaves ? root : child(root, 0); }
    LaneMasks open(Node index, const BoxPlacement* placement, OpenBoxes& boxes) const;
    /// OrientedBoxKernel::node_on_segment() for a node's boxes, which is faster than opening the node. Sets `leaves` to
    /// the boxes that are leaves. Requires !of_triangles(index).
    unsigned on_segment(Node index, const SegmentLine& line, float (&entry)[8], unsigned& leaves) const;
    std::span<const std::uint32_t> primitives(Node index, unsigned k) const
    {
        if (of_triangles(index)) return {order_ + place_of(index) + k, 1};
        return {order_ + begin_of(index, k), std::size_t(node(index).singles >> k & 1 ? 1 : 2)};
    }
    /// True for the node below a leaf: its boxes hold one triangle each, and are made when it is opened.
    static constexpr bool of_triangles(Node index) { return index >> 31; }
    /// The stored data of a node for which of_triangles() is false.
    const BoxNode& node(Node index) const { return node_at(blocks_, index); }
    /// The triangles of box k are [begin, begin + count) of the tree's order. Requires !of_triangles(index).
    std::uint32_t begin_of(Node index, unsigned k) const
    {
        const BoxNode& from = node(index);
        return from.inner ? inner_at(blocks_, index).begin[k] : from.begin + (from.offsets >> 4 * k & 15);
    }
    std::uint32_t count_of(Node index, unsigned k) const
    {
        const BoxNode& from = node(index);
        return from.leaves >> k & 1 ? (from.singles >> k & 1 ? 1 : 2) : inner_at(blocks_, index).count[k];
    }
    /// True if the child node of box k is stored.
    bool is_grown(Node index, unsigned k) const { return !(node(index).leaves >> k & 1) && grown(index, k); }
    /// The child node of box k, grown if it does not exist yet. The box must hold more than one triangle.
    Node child(Node index, unsigned k)
    {
        if (node(index).leaves >> k & 1) return parts_of_leaf(begin_of(index, k));
        const Node child = grown(index, k);
        return child ? child : grow(index, k);
    }
    /// The box must be no leaf.
    void prefetch_child(Node index, unsigned k)
    {
        prefetch_node(grown(index, k)); // node 0, the root, if the child is not grown yet
    }
    /// Call it after vertices [first, first + count) of the mesh have moved and its bounds were renewed, while no
    /// traversal runs. Not for a cooked mesh. @param radius2  as VertexMove::radius2. Cost: O(clusters). The first
    /// traversal that opens a node of many triangles makes a pass over the vertices, 3 ns each.
    void deform(std::uint32_t first, std::uint32_t count, double radius2);
    /// How many boxes were fitted anew since the tree was made.
    std::uint64_t boxes_refitted() const;

    /// Grows the nodes that a traversal with a body in this box of the mesh's frame would reach, down to boxes of
    /// `triangles` triangles. May run concurrently with traversals.
    void grow_in(const Aabb& box, std::uint32_t triangles);
    /// A box of at most this many triangles counts as a leaf. If it is larger than the box that it is compared with,
    /// its triangles can still get boxes of their own.
    static constexpr std::uint32_t leaf_triangles = MeshChunks::leaf_triangles;

    /// The triangle at a position of the tree's order, by number in the mesh.
    std::uint32_t triangle(std::uint32_t place) const { return order_[place]; }
    /// Not available for a cooked mesh.
    const Mesh& mesh() const
    {
        ONCOLLIDE_ASSERT(mesh_);
        return *mesh_;
    }
    /// Prefetches the positions in the tree's order of the first triangles in box k, which must be no leaf.
    void prefetch_order(Node index, unsigned k) const { prefetch(order_ + inner_at(blocks_, index).begin[k]); }
    /// Prefetches the corners of the triangles in leaf box k of an open node.
    void prefetch_primitives(Node index, unsigned k) const
    {
        for (const std::uint32_t triangle : primitives(index, k)) prefetch_corners(triangle);
    }
    /// Prefetch the data that traversals read first: the node table and, some time later, the root.
    void prefetch_table() const { prefetch_all_of(blocks_[0]); }
    void prefetch_root() const { prefetch(&node(root), 2 * sizeof(InnerNode)); }
    void prefetch_node(Node index) const
    {
        if (of_triangles(index))
            prefetch_all_of(order_[place_of(index)]);
        else
            prefetch(&node(index), sizeof(BoxNode) + sizeof(InnerNode::child)); // a BoxNode alone is smaller
    }
    /// Prefetch the corner indices of a triangle and, some time later, the corners.
    void prefetch_triangle(std::uint32_t triangle) const { prefetch_all_of(triangles_[triangle]); }
    void prefetch_corners(std::uint32_t triangle) const
    {
        for (const std::uint32_t corner : triangles_[triangle]) prefetch_all_of(vertices_[corner]);
    }
    /// True if prefetching all children pays: a large tree, and each of many smaller ones, is mostly not in the nearest
    /// caches when a traversal reaches it. False for few triangles, and for cooked meshes, whose data below a box may
    /// not be loaded.
    bool is_large() const { return large_; }

    /// True if the mesh, cooked or not, has many triangles.
    bool has_many() const { return !(node(root).leaves & 1) && count_of(root, 0) >= many_from; }

    /// Indexed by number in the tree. In a cooked mesh only entries that traversals have reached are valid.
    const Eigen::Vector3d* vertices() const { return vertices_; }
    const Triangle* triangles() const { return triangles_; }
    TrianglePoints corners(std::uint32_t triangle) const
    {
        const Triangle& t = triangles_[triangle];
        return {vertices_[t[0]], vertices_[t[1]], vertices_[t[2]]};
    }
    /// The number in the source of a triangle that a traversal has reached.
    std::uint32_t source(std::uint32_t triangle) const { return chunked_ ? chunked_->number(triangle) : triangle; }
    /// True if a traversal has reached the triangle and it was not dropped since; otherwise it is not a valid hint.
    bool holds(std::uint32_t triangle) const { return !chunked_ || chunked_->there(chunked_->chunk_of(triangle)); }

    /// The triangles at these positions of the tree's order, which traversals sort as they grow the tree.
    void copy_order(std::uint32_t begin, std::uint32_t count, std::vector<std::uint32_t>& to) const;
    /// Overwrites `growth` with the parts that a copy of the first `from` lines lacks; 0: all. May run concurrently
    /// with traversals. Not for a cooked mesh. Cost: O(nodes).
    void copy_growth(std::uint32_t from, TreeGrowth& growth) const;
    /// Null if the tree counts in none.
    BoxTotals* totals() const { return totals_; }
    /// True if the vertices have moved.
    bool deformed() const { return deformation_ != nullptr; }
    /// Null unless the mesh is cooked.
    MeshChunks* chunked() const { return chunked_.get(); }
    void add_held(std::vector<Held>& to) const override;
    void drop(std::uint32_t of_chunks) override;

    /// Lines of nodes in use. Not for a cooked mesh.
    std::uint32_t lines() const { return lines_; }
    std::uint32_t nodes() const { return chunked_ ? chunked_->nodes() : nodes_.load(); }
    /// Unique to this tree, and renewed when it drops a chunk or divides its triangles anew: nodes of another tree,
    /// even of the same mesh, are not its nodes.
    std::uint32_t identity() const { return identity_; }
    std::size_t bytes() const;
    static std::uint64_t most_nodes(std::size_t triangles); ///< when fully grown
    static std::size_t most_bytes(std::size_t triangles);
    static double radius_around(const Mesh& mesh); ///< radius() of its tree
    /// @param radius2  greatest squared distance of a triangle's corner from the centre
    static double radius_from(double radius2) { return std::sqrt(radius2) * (1 + 0x1p-50) + 1e-150; }
    /// Returns the first fault of the whole tree as text; empty: it has none. Assertions and tests call it while no
    /// traversal runs. It examines no cooked mesh, whose chunks are checked when they are read. Cost: O(n log n).
    std::string validate() const;

private:
    static constexpr std::size_t prefetched_from = 64, many_from = 2048; ///< triangles
    static constexpr unsigned most_lanes = 8;
    std::string fault_of_node(Node index, std::uint32_t begin, std::uint32_t count) const;
    static std::uint64_t most_lines(std::size_t triangles);
    std::size_t room_in(std::size_t number) const; ///< lines of block `number`

    static constexpr Node parts_of_leaf(std::uint32_t place) { return 1u << 31 | place; }
    static constexpr std::uint32_t place_of(Node index) { return index & ~(1u << 31); }
    LaneMasks open_triangles(Node index, const BoxPlacement* placement, OpenBoxes& boxes) const;

    /// The child node of box k, which must not be a leaf; 0: not grown yet.
    Node grown(Node index, unsigned k) const
    {
        return std::atomic_ref(inner_at(blocks_, index).child[k]).load(std::memory_order_acquire);
    }
    void make_table();
    void drop_table();
    void make_root(std::size_t triangles);
    void number_triangles();
    Node grow(Node parent, unsigned k);
    Node grow_locked(Node parent, unsigned k);
    void make_current(Node index) const;
    Node add_node(bool inner);
    void count(std::uint64_t nodes, std::size_t bytes);
    Node grow_by_grid(InnerNode& above, unsigned k);
    Node add_nodes(const GridPart& part, std::uint32_t begin);
    struct Growing; ///< working memory of a thread
    static Growing& growing();
    static void add_lane(BoxNode& node, std::size_t from, std::size_t to, std::uint32_t begin);
    static void fit_lanes(Growing& g, BoxNode& node);
    class Deformation; // obb_tree_deform.cpp

    const Mesh* const mesh_; ///< null for a cooked mesh
    BoxTotals* const totals_;
    const std::unique_ptr<MeshChunks> chunked_;
    std::unique_ptr<Deformation> deformation_; ///< null: the vertices have not moved
    std::uint32_t identity_;
    Eigen::Vector3d centre_;
    double radius_;
    const bool large_;
    bool checks_; ///< make_current() prepares a node before it is opened
    const Eigen::Vector3d* vertices_;
    const Triangle* triangles_;
    std::uint32_t* order_ = nullptr;       ///< null until a box grows
    NodeLine** blocks_;                    ///< table for all possible blocks; a block is null until used
    LargeVector<std::uint32_t> own_order_; ///< storage of order_ and blocks_, unless the mesh is cooked
    std::vector<NodeLine*> own_blocks_;
    std::atomic<std::uint32_t> lines_ = 0, nodes_ = 0; ///< lines and nodes in use, in these blocks
    mutable OrderedMutex<LockRank::obb_tree> growing_;
    std::uint32_t grows_in_ = 0; ///< the chunk of a cooked mesh that is growing
};

} // namespace oncollide
