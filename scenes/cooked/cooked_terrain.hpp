#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <oncollide/base/threads/lock_order.hpp>
#include <oncollide/scenes/cooked/chunk_budget.hpp>
#include <oncollide/scenes/cooked/cooked_file.hpp>
#include <oncollide/scenes/model/terrain/terrain_chunks.hpp>

namespace oncollide {

class CookedBytes;

/// A grid of heights in a cooked file (docs/cooked.md), of which only the top is read. The heights lie in chunks of 64
/// by 64. Const calls are safe from many threads at once.
class CookedTerrain {
public:
    /// Throws as CookedMesh does.
    explicit CookedTerrain(const std::filesystem::path& path);

    const CookedFile& file() const { return file_; }
    /// The checksum in the header, which covers the checksums of all other data.
    std::uint64_t checksum() const { return checksum_; }
    /// The terrain without its heights and diagonals.
    const Terrain& outline() const { return *outline_; }
    std::uint32_t across() const { return across_; } ///< chunks in a row
    std::size_t chunks() const { return table_.size(); }
    std::uint32_t blocks_across() const { return blocks_across_; }     ///< blocks of 64 by 64 cells in a row
    const std::vector<CookedRange>& ranges() const { return ranges_; } ///< bounds of these blocks, row by row
    std::size_t bytes() const { return table_.size() * sizeof(table_[0]) + ranges_.size() * sizeof(ranges_[0]); }

    const std::optional<std::vector<CookedPart>>& parts() const { return parts_; } ///< empty: not known

    /// Throws ChunkFault; later calls for this chunk throw the same error.
    std::unique_ptr<TerrainChunk> read(std::size_t chunk) const;
    std::size_t chunk_bytes(std::size_t chunk) const; ///< bytes in the file
    [[noreturn]] void refuse_chunk(std::size_t chunk, const std::string& why) const;

    static CookedTerrainRecord record_of(const Terrain& terrain);
    /// Appends the bytes of a chunk.
    static void add_chunk(const Terrain& terrain, std::size_t chunk, CookedBytes& to);

private:
    struct Extent {
        std::uint32_t columns, rows, tiles_x, tiles;
    };
    static Extent extent(const Terrain& terrain, std::size_t chunk);
    static std::uint64_t bytes_of(const Terrain& terrain, std::size_t chunk);
    void take_record(const CookedTerrainRecord& record, const CookedHeader& header);

    CookedFile file_;
    std::uint64_t checksum_ = 0;
    std::shared_ptr<const CookedFile::Handle> handle_;
    std::optional<Terrain> outline_;
    std::uint32_t across_ = 0, blocks_across_ = 0;
    std::vector<CookedChunkEntry> table_;
    std::vector<CookedRange> ranges_;
    std::optional<std::vector<CookedPart>> parts_;
};

/// The heights of a cooked terrain that are in memory.
class CookedTerrainChunks final : public TerrainChunks {
public:
    /// Without a budget, chunks that were read stay in memory.
    explicit CookedTerrainChunks(std::shared_ptr<const CookedTerrain> cooked, ChunkBudget* budget = nullptr);
    ~CookedTerrainChunks() override;
    /// A Terrain that reads such chunks.
    static Terrain terrain(std::shared_ptr<const CookedTerrain> cooked, ChunkBudget* budget = nullptr);

    const std::shared_ptr<const CookedTerrain>& cooked() const { return cooked_; }
    ChunkBudget& budget() const { return budget_; }

    bool there(std::size_t chunk) const { return chunks_[chunk].load(std::memory_order_acquire); }
    std::uint64_t needed(std::size_t chunk) const { return needed_[chunk].load(std::memory_order_relaxed); }
    void need_all() const override;
    void drop(std::size_t chunk); ///< No other thread may read heights meanwhile
    std::size_t bytes() const override { return held_.load(std::memory_order_relaxed) + cooked_->bytes(); }

private:
    CookedTerrainChunks(std::shared_ptr<const CookedTerrain> cooked, std::unique_ptr<ChunkBudget> own,
                        ChunkBudget* budget);
    const TerrainChunk& need(std::size_t chunk) const override;

    std::shared_ptr<const CookedTerrain> cooked_;
    std::unique_ptr<ChunkBudget> own_;
    ChunkBudget& budget_;
    mutable std::atomic<std::size_t> held_ = 0;
    mutable OrderedMutex<LockRank::chunks> reading_;
};

/// The chunks of a terrain in a cooked file; null: the whole terrain is in memory.
CookedTerrainChunks* cooked_chunks(const Terrain& terrain);

} // namespace oncollide
