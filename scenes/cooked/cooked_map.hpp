#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include <oncollide/base/memory/lazy_memory.hpp>
#include <oncollide/base/threads/lock_order.hpp>
#include <oncollide/scenes/cooked/chunk_budget.hpp>
#include <oncollide/scenes/cooked/cooked_file.hpp>
#include <oncollide/scenes/model/map/map_access.hpp>
#include <oncollide/scenes/model/map/map_chunks.hpp>

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

    /// Throws as CookedMesh does.
    explicit CookedMap(const std::filesystem::path& path);

    const CookedFile& file() const { return file_; }
    /// The checksum in the header, which covers the checksums of all other data.
    std::uint64_t checksum() const { return checksum_; }
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

/// The nodes of a cooked map that are in memory.
class CookedMapChunks final : public MapChunks, public HeldChunks {
public:
    /// Without a budget, chunks that were read stay in memory.
    explicit CookedMapChunks(std::shared_ptr<const CookedMap> cooked, ChunkBudget* budget = nullptr);
    ~CookedMapChunks() override;
    /// An OccupancyMap that reads such chunks.
    static OccupancyMap map(std::shared_ptr<const CookedMap> cooked, ChunkBudget* budget = nullptr);

    const std::shared_ptr<const CookedMap>& cooked() const { return cooked_; }

    void need_all() const override;
    void add_held(std::vector<Held>& to) const override;
    void drop(std::uint32_t chunk) override;
    std::size_t bytes() const override { return held_.load(std::memory_order_relaxed) + cooked_->bytes(); }

private:
    CookedMapChunks(std::shared_ptr<const CookedMap> cooked, std::unique_ptr<ChunkBudget> own, ChunkBudget* budget);
    void need(std::uint32_t chunk) const override;
    std::size_t bytes_of(std::uint32_t chunk) const; ///< bytes in memory

    std::shared_ptr<const CookedMap> cooked_;
    std::unique_ptr<ChunkBudget> own_;
    ChunkBudget& budget_;
    mutable LazyMemory memory_;
    mutable std::atomic<std::size_t> held_ = 0;
    mutable OrderedMutex<LockRank::chunks> reading_;
};

/// The chunks of a map in a cooked file; null: the whole map is in memory.
CookedMapChunks* cooked_chunks(const OccupancyMap& map);

/// Writes a map, except its probabilities, to a file.
void add_map(const OccupancyMap& map, std::uint32_t most_in_chunk, CookedWriter& file);

} // namespace oncollide
