#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <oncollide/base/lock_order.hpp>
#include <oncollide/scenes/cooked/chunk_budget.hpp>
#include <oncollide/scenes/cooked/cooked_file.hpp>
#include <oncollide/scenes/model/terrain_access.hpp>

namespace oncollide {

class CookedBytes;

/// A grid of heights in a cooked file (docs/cooked.md), of which only the top is read. The heights lie in chunks of 64
/// by 64. Const calls are safe from many threads at once.
class CookedTerrain {
public:
    static constexpr std::uint32_t side = 64; ///< heights, or cells, per side of a chunk

    /// Throws as CookedMesh does.
    explicit CookedTerrain(const std::filesystem::path& path);

    const CookedFile& file() const { return file_; }
    std::uint64_t checksum() const { return checksum_; } ///< from the header; covers the checksums of all other data
    /// The terrain without its heights and diagonals.
    const Terrain& outline() const { return *outline_; }
    std::uint32_t across() const { return across_; } ///< chunks in a row
    std::size_t chunks() const { return table_.size(); }
    std::uint32_t blocks_across() const { return blocks_across_; }     ///< of 64 by 64 cells
    const std::vector<CookedRange>& ranges() const { return ranges_; } ///< of these blocks, row by row
    std::size_t bytes() const { return table_.size() * sizeof(table_[0]) + ranges_.size() * sizeof(ranges_[0]); }

    const std::optional<std::vector<CookedPart>>& parts() const { return parts_; } ///< empty: not known

    /// A chunk's heights, in tiles as a terrain has them.
    struct Chunk {
        std::uint32_t tiles_x = 0;          ///< tiles per row
        std::vector<TerrainTile> tiles;     ///< at 1 and 2 bytes
        std::vector<std::byte> samples;     ///< tile by tile
        std::vector<std::uint64_t> falling; ///< a bit per cell, 64 per row; empty: all cells have the same diagonal
    };
    /// Throws ChunkFault; later calls for this chunk throw the same error.
    std::unique_ptr<Chunk> read(std::size_t chunk) const;
    std::size_t chunk_bytes(std::size_t chunk) const; ///< in the file
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

/// The heights of a cooked terrain that are in memory: each chunk is read when one of its heights is first used. Many
/// threads may do so at once.
class TerrainChunks {
public:
    /// Without a budget, chunks that were read stay in memory.
    explicit TerrainChunks(std::shared_ptr<const CookedTerrain> cooked, ChunkBudget* budget = nullptr);
    ~TerrainChunks();
    /// A Terrain that reads such chunks.
    static Terrain terrain(std::shared_ptr<const CookedTerrain> cooked, ChunkBudget* budget = nullptr);

    const std::shared_ptr<const CookedTerrain>& cooked() const { return cooked_; }
    ChunkBudget& budget() const { return budget_ ? *budget_ : *own_; }

    double height(std::uint32_t column, std::uint32_t row) const
    {
        constexpr std::uint32_t side = CookedTerrain::side, tile = Terrain::tile;
        const CookedTerrain::Chunk& chunk = at(std::size_t(row / side) * cooked_->across() + column / side);
        const std::uint32_t number = row % side / tile * chunk.tiles_x + column % side / tile;
        double height;
        decode(cooked_->outline(), chunk, number, row % tile * tile + column % tile, 1, &height);
        return height;
    }
    /// The heights of columns [from, to) in a row.
    void read_row(std::uint32_t row, std::uint32_t from, std::uint32_t to, double* out) const;
    CellDiagonal diagonal(std::uint32_t x, std::uint32_t y) const
    {
        constexpr std::uint32_t side = CookedTerrain::side;
        const CookedTerrain::Chunk& chunk = at(std::size_t(y / side) * cooked_->across() + x / side);
        return chunk.falling[y % side] >> x % side & 1 ? CellDiagonal::falling : CellDiagonal::rising;
    }

    bool there(std::size_t chunk) const { return chunks_[chunk].load(std::memory_order_acquire); }
    std::uint64_t needed(std::size_t chunk) const { return needed_[chunk].load(std::memory_order_relaxed); }
    /// Marks the chunk that begins at the corner of a block of cells as used.
    void mark(std::uint32_t x, std::uint32_t y) const
    {
        budget().mark(needed_[std::size_t(y) * cooked_->across() + x]);
    }
    void need_all() const;        ///< Throws ChunkFault
    void drop(std::size_t chunk); ///< No other thread may read heights meanwhile
    std::size_t bytes() const { return held_.load(std::memory_order_relaxed) + cooked_->bytes(); }

private:
    const CookedTerrain::Chunk& at(std::size_t chunk) const
    {
        const CookedTerrain::Chunk* there = chunks_[chunk].load(std::memory_order_acquire);
        budget().mark(needed_[chunk]);
        return there ? *there : need(chunk);
    }
    const CookedTerrain::Chunk& need(std::size_t chunk) const;
    friend class CookedTerrain;
    /// Heights k to k + count - 1 of a tile.
    static void decode(const Terrain& terrain, const CookedTerrain::Chunk& chunk, std::uint32_t tile, std::uint32_t k,
                       std::uint32_t count, double* out);
    template <class Sample>
    static void decode_as(const Terrain& terrain, const CookedTerrain::Chunk& chunk, std::uint32_t tile,
                          std::uint32_t k, std::uint32_t count, double* out);

    std::shared_ptr<const CookedTerrain> cooked_;
    std::unique_ptr<ChunkBudget> own_;
    ChunkBudget* budget_;
    mutable std::vector<std::atomic<CookedTerrain::Chunk*>> chunks_;
    mutable std::vector<std::atomic<std::uint64_t>> needed_;
    mutable std::atomic<std::size_t> held_ = 0;
    mutable OrderedMutex<LockRank::chunks> reading_;
};

} // namespace oncollide
