#pragma once
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include <oncollide/base/large_vector.hpp>
#include <oncollide/base/prefetch.hpp>
#include <oncollide/narrowphase/obb/grid_split.hpp>
#include <oncollide/narrowphase/obb/hierarchy.hpp>
#include <oncollide/narrowphase/obb/mesh_chunks.hpp>
#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// What trees of oriented boxes hold, all together. The trees keep it up to date.
struct BoxTotals {
    std::atomic<std::uint64_t> nodes = 0;
    std::atomic<std::size_t> bytes = 0;
};

/// Oriented boxes around the triangles of one mesh, eight below each, a BoxHierarchy that grows while it is walked: a
/// box gets its parts when a walk first opens it, so that a scene pays for the parts of its meshes that come close to
/// others.
///
/// The triangles of a box are parted three times, each time where boxes around the parts have the least area for their
/// triangles, but into parts of two fifths at least, so the tree is at most 0.46 log2(n) + 2 nodes deep whatever the
/// triangles. What a node holds depends on the mesh alone, not on who walked first.
/// Walks may grow the tree side by side.
class ObbTree final : public HeldChunks {
public:
    /// Keeps references to the mesh and to the totals that it counts in. Cost: 5 ns a triangle; the first walk costs
    /// some 50.
    explicit ObbTree(const Mesh& mesh, BoxTotals* totals = nullptr);
    /// Of a cooked mesh: the same tree, but that triangles have other numbers (source()). Its upper levels are those of
    /// the file, and chunks of triangles are read when a walk first comes to them: open() and child() throw ChunkFault,
    /// and the walk ends. Cost: that of the upper levels.
    ObbTree(std::shared_ptr<const CookedMesh> mesh, ChunkBudget& budget);
    ~ObbTree() override;
    ObbTree(const ObbTree&) = delete;
    ObbTree& operator=(const ObbTree&) = delete;

    using Node = std::uint32_t;
    using Primitive = std::uint32_t; ///< a triangle, by its number in the mesh

    /// Boxes and nodes are relative to this point of the mesh's frame.
    const Eigen::Vector3d& centre() const { return centre_; }
    double radius() const { return radius_; } ///< of the triangles' corners, from the centre, at most

    /// A node that holds the box of the whole mesh alone.
    static constexpr Node root = 0;
    LaneMasks open(Node index, const BoxPlacement* placement, OpenBoxes& boxes) const;
    std::span<const std::uint32_t> primitives(Node index, unsigned k) const
    {
        if (of_triangles(index)) return {order_ + place_of(index) + k, 1};
        return {order_ + begin_of(index, k), std::size_t(node(index).singles >> k & 1 ? 1 : 2)};
    }
    /// Is it the node of a leaf's parts? Its boxes are around one triangle each, and made when it is opened.
    static constexpr bool of_triangles(Node index) { return index >> 31; }
    /// What is stored of a node; not of_triangles().
    const BoxNode& node(Node index) const { return node_at(blocks_, index); }
    /// The triangles of box k are [begin, begin + count) of the tree's order. Not of_triangles().
    std::uint32_t begin_of(Node index, unsigned k) const
    {
        const BoxNode& from = node(index);
        return from.inner ? inner_at(blocks_, index).begin[k] : from.begin + from.offset[k];
    }
    std::uint32_t count_of(Node index, unsigned k) const
    {
        const BoxNode& from = node(index);
        return from.leaves >> k & 1 ? (from.singles >> k & 1 ? 1 : 2) : inner_at(blocks_, index).count[k];
    }
    /// Is the node of its parts there, and stored?
    bool is_grown(Node index, unsigned k) const { return !(node(index).leaves >> k & 1) && grown(index, k); }
    /// The node of the parts of box k, grown when it is not there yet. The box must hold more than one triangle.
    Node child(Node index, unsigned k)
    {
        if (node(index).leaves >> k & 1) return parts_of_leaf(begin_of(index, k));
        const Node child = grown(index, k);
        return child ? child : grow(index, k);
    }
    /// Of a box that is no leaf.
    void prefetch_child(Node index, unsigned k)
    {
        prefetch_node(grown(index, k)); // the root where it is not there yet
    }
    /// Grows what a walk with a body in this box of the mesh's frame would come to, down to boxes of so many triangles.
    /// Beside walks.
    void grow_in(const Aabb& box, std::uint32_t triangles);
    /// A box of so many triangles or fewer counts as a leaf. Where it is much larger than what it is compared with, its
    /// triangles can still get boxes of their own.
    static constexpr std::uint32_t leaf_triangles = MeshChunks::leaf_triangles;

    /// The triangle at a place of the tree's order, by number in the mesh.
    std::uint32_t triangle(std::uint32_t place) const { return order_[place]; }
    /// Not of a cooked mesh.
    const Mesh& mesh() const
    {
        ONCOLLIDE_ASSERT(mesh_);
        return *mesh_;
    }
    /// Begin to load what walks look at first: where the nodes are, and, some time later, these.
    void prefetch_table() const { prefetch_all_of(blocks_[0]); }
    void prefetch_root() const { prefetch(&node(root), 2 * sizeof(InnerNode)); }
    void prefetch_node(Node index) const
    {
        if (of_triangles(index))
            prefetch_all_of(order_[place_of(index)]);
        else
            prefetch(&node(index), sizeof(BoxNode) + sizeof(InnerNode::child)); // not all are so large
    }
    /// Of a triangle first which corners it has, and, some time later, these.
    void prefetch_triangle(std::uint32_t triangle) const { prefetch_all_of(triangles_[triangle]); }
    void prefetch_corners(std::uint32_t triangle) const
    {
        for (const std::uint32_t corner : triangles_[triangle]) prefetch_all_of(vertices_[corner]);
    }
    /// Is it so large that nodes and triangles are mostly not in the nearest caches when a walk comes to them? Then it
    /// pays to fetch all children early. Cooked meshes do not count: what is below a box may not be there.
    bool is_large() const { return large_; }

    /// By number in the tree. Of a cooked mesh only what walks have come to.
    const Eigen::Vector3d* vertices() const { return vertices_; }
    const Triangle* triangles() const { return triangles_; }
    TrianglePoints corners(std::uint32_t triangle) const
    {
        const Triangle& t = triangles_[triangle];
        return {vertices_[t[0]], vertices_[t[1]], vertices_[t[2]]};
    }
    /// The number in the source of a triangle that a walk has come to.
    std::uint32_t source(std::uint32_t triangle) const { return chunked_ ? chunked_->number(triangle) : triangle; }
    /// Is it one that a walk has come to, and that was not dropped since? Else it is no hint.
    bool holds(std::uint32_t triangle) const { return !chunked_ || chunked_->there(chunked_->chunk_of(triangle)); }

    /// Of a cooked mesh; else null.
    MeshChunks* chunked() const { return chunked_.get(); }
    void add_held(std::vector<Held>& to) const override;
    void drop(std::uint32_t of_chunks) override;

    std::uint32_t nodes() const { return chunked_ ? chunked_->nodes() : nodes_.load(); }
    /// Of this tree and no other: nodes of one are no nodes of another, though it may be of the same mesh.
    std::uint32_t identity() const { return identity_; }
    std::size_t bytes() const;
    static std::uint64_t most_nodes(std::size_t triangles); ///< when all is grown
    static std::size_t most_bytes(std::size_t triangles);
    static double radius_around(const Mesh& mesh); ///< radius() of its tree

private:
    static std::uint64_t most_lines(std::size_t triangles);
    std::size_t room_in(std::size_t number) const; ///< lines of a block

    static constexpr Node parts_of_leaf(std::uint32_t place) { return 1u << 31 | place; }
    static constexpr std::uint32_t place_of(Node index) { return index & ~(1u << 31); }
    LaneMasks open_triangles(Node index, const BoxPlacement* placement, OpenBoxes& boxes) const;

    /// The node of the parts of box k, which is no leaf; 0: none yet.
    Node grown(Node index, unsigned k) const
    {
        return std::atomic_ref(inner_at(blocks_, index).child[k]).load(std::memory_order_acquire);
    }
    void make_root(const Aabb& bounds, std::size_t triangles);
    void number_triangles();
    Node grow(Node parent, unsigned k);
    Node add_node(bool inner);
    void count(std::uint64_t nodes, std::size_t bytes);
    Node grow_by_grid(InnerNode& above, unsigned k);
    Node add_nodes(const GridPart& part, std::uint32_t begin);
    struct Growing; ///< what a thread works with
    static Growing& growing();
    void add_lane(Growing& g, Node index, std::size_t from, std::size_t to, std::uint32_t begin);

    const Mesh* const mesh_; ///< null: a cooked one
    BoxTotals* const totals_;
    const std::unique_ptr<MeshChunks> chunked_;
    std::uint32_t identity_;
    Eigen::Vector3d centre_;
    double radius_;
    const bool large_;
    const Eigen::Vector3d* vertices_;
    const Triangle* triangles_;
    std::uint32_t* order_ = nullptr;       ///< null until a box grows
    NodeLine** blocks_;                    ///< as many as there can be; null until used
    LargeVector<std::uint32_t> own_order_; ///< what these point to, but of a cooked mesh
    std::vector<NodeLine*> own_blocks_;
    std::atomic<std::uint32_t> lines_ = 0, nodes_ = 0; ///< in use, of these blocks
    std::mutex growing_;
    std::uint32_t grows_in_ = 0; ///< the chunk of a cooked mesh where it grows
};

} // namespace oncollide
