#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include <oncollide/base/lazy_memory.hpp>
#include <oncollide/base/lock_order.hpp>
#include <oncollide/scenes/cooked/chunk_budget.hpp>
#include <oncollide/scenes/cooked/cooked_file.hpp>
#include <oncollide/scenes/model/map_access.hpp>

namespace oncollide {

class CookedWriter;

/// An occupancy map in a cooked file (docs/cooked.md), of which only the top is read: the nodes of the octree's upper
/// levels. Each subtree below the top is in one chunk, of up to 4096 nodes. Const calls are safe from many threads at
/// once.
///
/// Nodes are numbered by their position in memory: the top's nodes from 0, each chunk's from a multiple of 512.
/// Children follow in the order of their parents, so each node has only one possible position for its octants.
class CookedMap {
public:
    using Node = CellTree::Node;
    static constexpr std::uint32_t step = 512; ///< nodes per page

    /// Throws as CookedMesh does.
    explicit CookedMap(const std::filesystem::path& path);

    const CookedFile& file() const { return file_; }
    std::uint64_t checksum() const { return checksum_; } ///< from the header; covers the checksums of all other data
    const CookedMapRecord& record() const { return record_; }
    const Node& grid() const { return grid_; } ///< its octant 0 is the grid: CellTree::top()
    const std::vector<Node>& top() const { return top_; }
    std::size_t chunks() const { return table_.size(); }
    std::uint32_t first(std::size_t chunk) const { return chunks_[chunk].first; }
    std::uint32_t nodes(std::size_t chunk) const
    {
        return static_cast<std::uint32_t>(table_[chunk].bytes / sizeof(Node));
    }
    std::uint32_t end() const { return end_; } ///< one more than the largest number
    std::size_t bytes() const
    {
        return table_.size() * (sizeof(table_[0]) + sizeof(Chunk)) + top_.size() * sizeof(Node) +
               entries_.size() * sizeof(Entry);
    }
    /// Throws ChunkFault; later calls for this chunk throw the same error.
    std::vector<Node> read(std::size_t chunk) const;

private:
    /// An octant of a node of the top whose subtree begins in a chunk.
    struct Entry {
        MapCell cube;
        bool solid; ///< as recorded in the parent node
    };
    struct Chunk {
        std::uint32_t first = 0;
        std::size_t entry = 0, entries = 0; ///< the chunk's first nodes, as a range of entries
    };
    void place_chunks(const CookedFile::Opened& opened);
    void check_top();
    const char* why_not_node(const Node& node, const MapCell& cube) const;

    CookedFile file_;
    std::uint64_t checksum_ = 0;
    std::shared_ptr<const CookedFile::Handle> handle_;
    CookedMapRecord record_{};
    Node grid_;
    std::vector<Node> top_;
    std::vector<CookedChunkEntry> table_;
    std::vector<Chunk> chunks_;
    std::vector<Entry> entries_;
    std::uint32_t end_ = 0;
};

/// The nodes of a cooked map that are in memory: each chunk is read when one of its nodes is first used. Many threads
/// may do so at once.
class MapChunks final : public HeldChunks {
public:
    /// Without a budget, chunks that were read stay in memory.
    explicit MapChunks(std::shared_ptr<const CookedMap> cooked, ChunkBudget* budget = nullptr);
    ~MapChunks() override;
    /// An OccupancyMap that reads such chunks.
    static OccupancyMap map(std::shared_ptr<const CookedMap> cooked, ChunkBudget* budget = nullptr);

    const std::shared_ptr<const CookedMap>& cooked() const { return cooked_; }

    const CellTree::Node& node(std::uint32_t number) const
    {
        if (const std::uint32_t of = chunk_of_[number / CookedMap::step]) {
            const Chunk& chunk = chunks_[of - 1];
            if (!chunk.there.load(std::memory_order_acquire)) need(of - 1);
            budget().mark(chunk.needed);
        }
        return nodes_[number];
    }
    void need_all() const; ///< Throws ChunkFault
    void add_held(std::vector<Held>& to) const override;
    void drop(std::uint32_t chunk) override;
    std::size_t bytes() const { return held_.load(std::memory_order_relaxed) + cooked_->bytes(); }

private:
    struct Chunk {
        std::atomic<bool> there = false;
        mutable std::atomic<std::uint64_t> needed = 0;
    };
    ChunkBudget& budget() const { return budget_ ? *budget_ : *own_; }
    void need(std::uint32_t chunk) const;
    std::size_t bytes_of(std::uint32_t chunk) const; ///< in memory

    std::shared_ptr<const CookedMap> cooked_;
    std::unique_ptr<ChunkBudget> own_;
    ChunkBudget* budget_;
    mutable LazyMemory memory_;
    CellTree::Node* nodes_;
    std::vector<std::uint32_t> chunk_of_; ///< by page: the chunk's number + 1; 0: the top
    mutable std::vector<Chunk> chunks_;
    mutable std::atomic<std::size_t> held_ = 0;
    mutable OrderedMutex<LockRank::chunks> reading_;
};

/// Writes a map, except its probabilities, to a file.
void add_map(const OccupancyMap& map, std::uint32_t most_in_chunk, CookedWriter& file);

} // namespace oncollide
