#pragma once
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <oncollide/base/memory/lazy_memory.hpp>
#include <oncollide/base/threads/lock_order.hpp>
#include <oncollide/narrowphase/obb/node_lines.hpp>
#include <oncollide/scenes/cooked/chunk_budget.hpp>
#include <oncollide/scenes/cooked/cooked_mesh.hpp>

namespace oncollide {

/// The triangles of a cooked mesh, numbered in the order of its tree; each chunk has its own pages, and is read when it
/// is needed. The class also holds the nodes, which are dropped with their chunk.
///
/// Many threads may read chunks concurrently; chunks are dropped only while no traversal runs.
class MeshChunks {
public:
    static constexpr std::uint32_t leaf_triangles = 2; ///< a box of at most this many triangles is a leaf

    /// A box of a node of the upper levels, by the node's number in the file; the root is 0.
    struct Lane {
        std::uint32_t node = 0, k = 0;
    };

    /// The upper levels are the root, node 0, which the caller makes, and the file's nodes. The budget must outlive
    /// this object. Throws ChunkFault if the nodes are no tree over the chunks.
    MeshChunks(std::shared_ptr<const CookedMesh> mesh, ChunkBudget& budget);
    ~MeshChunks();
    MeshChunks(const MeshChunks&) = delete;
    MeshChunks& operator=(const MeshChunks&) = delete;

    const CookedMesh& mesh() const { return *mesh_; }

    const Eigen::Vector3d* vertices() const { return vertices_; }
    const Triangle* triangles() const { return triangles_; }
    std::uint32_t* order() const { return order_; }
    /// The number of a triangle in the source. Its chunk must be loaded.
    std::uint32_t number(std::uint32_t triangle) const { return numbers_[triangle]; }
    const std::uint32_t* numbers() const { return numbers_; }

    NodeLine** blocks() const { return blocks_; } ///< an entry is null until its block is used
    /// Returns the number of the new node.
    std::uint32_t add_node(std::uint32_t chunk, bool inner);
    std::uint32_t nodes() const { return nodes_.load(std::memory_order_relaxed); }

    /// The position of the first triangle of a chunk, and the chunk of a triangle.
    std::uint32_t first(std::size_t chunk) const { return chunks_[chunk].first; }
    std::uint32_t chunk_of(std::uint32_t triangle) const;
    bool there(std::uint32_t chunk) const { return chunks_[chunk].there.load(std::memory_order_acquire); }
    /// Reads the chunk unless it is loaded, and checks the boxes above it. Throws ChunkFault.
    void need(std::uint32_t chunk);
    /// Call it when a traversal opens a node: it reads the chunks of the node's leaves. For a node below the upper
    /// levels, marks its chunk as needed now.
    void opened(std::uint32_t node);

    void add_held(std::vector<HeldChunks::Held>& to) const
    {
        for (std::uint32_t c = 0; c < chunks_.size(); ++c)
            if (there(c)) to.push_back({chunks_[c].needed.load(std::memory_order_relaxed), c});
    }
    /// Call it only while no traversal runs.
    void drop(std::uint32_t chunk);

    std::size_t bytes() const { return held_.load(std::memory_order_relaxed); }

private:
    struct Chunk {
        std::atomic<bool> there = false;
        std::atomic<std::uint64_t> needed = 0;
        std::uint32_t first, first_vertex; ///< triangle, vertex
        Lane lane;                         ///< the box of the upper levels around the chunk
        std::vector<std::uint32_t> blocks; ///< blocks of the chunk's nodes
        std::uint32_t nodes = 0;
        std::uint32_t next_line = 0, lines_end = 0; ///< free lines in the last block
        std::size_t held = 0;
    };
    static constexpr std::uint32_t upper_per_block = lines_per_block / inner_node_lines;
    /// The number in the tree of a node of the upper levels.
    static constexpr std::uint32_t number_of(std::uint32_t upper)
    {
        return upper / upper_per_block * lines_per_block + upper % upper_per_block * inner_node_lines;
    }
    InnerNode& upper(std::uint32_t node) { return inner_at(blocks_, number_of(node)); }
    void place_chunks();
    [[noreturn]] void refuse(std::uint32_t node, const char* what) const;
    void read_upper_nodes();
    void check_upper_node(std::uint32_t index, std::uint64_t expected);
    void link_upper_nodes();
    void check_boxes(std::uint32_t chunk, std::span<const Eigen::Vector3d> vertices);
    std::size_t data_bytes(std::uint32_t chunk) const;

    struct Empty {};
    MeshChunks(Empty, std::shared_ptr<const CookedMesh> mesh, ChunkBudget& budget);

    const std::shared_ptr<const CookedMesh> mesh_;
    const std::shared_ptr<const CookedMesh::Top> top_;
    ChunkBudget& budget_;
    LazyMemory memory_;
    Eigen::Vector3d* vertices_ = nullptr;
    Triangle* triangles_ = nullptr;
    std::uint32_t *order_ = nullptr, *numbers_ = nullptr;
    NodeLine** blocks_ = nullptr;
    std::uint32_t* owner_ = nullptr; ///< by block: its chunk + 1
    std::uint32_t upper_ = 0, next_block_ = 0;
    std::vector<Lane> above_; ///< by node of the upper levels: the box that it divides
    std::vector<Chunk> chunks_;
    std::vector<std::uint32_t> free_blocks_;
    std::atomic<std::uint32_t> nodes_ = 0;
    std::atomic<std::size_t> held_ = 0;
    OrderedMutex<LockRank::chunks> reading_;
    CookedMesh::Chunk read_;
};

} // namespace oncollide
