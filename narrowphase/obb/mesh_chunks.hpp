#pragma once
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include <oncollide/base/lazy_memory.hpp>
#include <oncollide/narrowphase/obb/node_lines.hpp>
#include <oncollide/scenes/cooked/chunk_budget.hpp>
#include <oncollide/scenes/cooked/cooked_mesh.hpp>

namespace oncollide {

/// The triangles of a cooked mesh as its tree sees them: numbered in the order of the tree, each chunk on pages of its
/// own, read when it is needed. Also the nodes, which go with their chunk.
///
/// Chunks may be read by many threads at once; they are dropped while nobody walks.
class MeshChunks {
public:
    static constexpr std::uint32_t leaf_triangles = 2; ///< a box of so many or fewer is a leaf

    /// A box of a node of the upper levels, by its place in the file; the root is 0.
    struct Lane {
        std::uint32_t node = 0, k = 0;
    };

    /// The upper levels are the root, node 0, which the caller makes, and the file's nodes. The budget must outlive it.
    /// Throws ChunkFault where these are no tree over the chunks.
    MeshChunks(std::shared_ptr<const CookedMesh> mesh, ChunkBudget& budget);
    ~MeshChunks();
    MeshChunks(const MeshChunks&) = delete;
    MeshChunks& operator=(const MeshChunks&) = delete;

    const CookedMesh& mesh() const { return *mesh_; }

    const Eigen::Vector3d* vertices() const { return vertices_; }
    const Triangle* triangles() const { return triangles_; }
    std::uint32_t* order() const { return order_; }
    /// The number of a triangle in the source. Its chunk must be there.
    std::uint32_t number(std::uint32_t triangle) const { return numbers_[triangle]; }
    const std::uint32_t* numbers() const { return numbers_; }

    NodeLine** blocks() const { return blocks_; } ///< null: none yet
    /// Returns its number.
    std::uint32_t add_node(std::uint32_t chunk, bool inner);
    std::uint32_t nodes() const { return nodes_.load(std::memory_order_relaxed); }

    /// The place of the first triangle of a chunk, and the chunk of a triangle.
    std::uint32_t first(std::size_t chunk) const { return chunks_[chunk].first; }
    std::uint32_t chunk_of(std::uint32_t triangle) const;
    bool there(std::uint32_t chunk) const { return chunks_[chunk].there.load(std::memory_order_acquire); }
    /// Reads it unless it is there, and checks the boxes above it. Throws ChunkFault.
    void need(std::uint32_t chunk);
    /// A walk opens the node: the chunks of its leaves are read; that of a node below is marked as needed now.
    void opened(std::uint32_t node);

    void add_held(std::vector<HeldChunks::Held>& to) const
    {
        for (std::uint32_t c = 0; c < chunks_.size(); ++c)
            if (there(c)) to.push_back({chunks_[c].needed.load(std::memory_order_relaxed), c});
    }
    /// Not while anybody walks.
    void drop(std::uint32_t chunk);

    std::size_t bytes() const { return held_.load(std::memory_order_relaxed); }

private:
    struct Chunk {
        std::atomic<bool> there = false;
        std::atomic<std::uint64_t> needed = 0;
        std::uint32_t first, first_vertex; ///< triangle, vertex
        Lane lane;                         ///< of the upper levels, whose box is around it
        std::vector<std::uint32_t> blocks; ///< of its nodes
        std::uint32_t nodes = 0;
        std::uint32_t next_line = 0, lines_end = 0; ///< room in the last block
        std::size_t held = 0;
    };
    static constexpr std::uint32_t upper_per_block = lines_per_block / inner_node_lines;
    /// The number of a node of the upper levels.
    static constexpr std::uint32_t number_of(std::uint32_t upper)
    {
        return upper / upper_per_block * lines_per_block + upper % upper_per_block * inner_node_lines;
    }
    InnerNode& upper(std::uint32_t node) { return inner_at(blocks_, number_of(node)); }
    void place_chunks();
    void add_upper_nodes();
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
    std::uint32_t* owner_ = nullptr; ///< of a block: its chunk + 1
    std::uint32_t upper_ = 0, next_block_ = 0;
    std::vector<Lane> above_; ///< by node of the upper levels: the box that it is the parts of
    std::vector<Chunk> chunks_;
    std::vector<std::uint32_t> free_blocks_;
    std::atomic<std::uint32_t> nodes_ = 0;
    std::atomic<std::size_t> held_ = 0;
    std::mutex reading_;
    CookedMesh::Chunk read_;
};

} // namespace oncollide
