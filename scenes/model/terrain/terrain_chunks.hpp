#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/model/chunk_clock.hpp>
#include <oncollide/scenes/model/terrain/terrain_access.hpp>

namespace oncollide {

/// The heights of a chunk, in tiles as a terrain has them.
struct TerrainChunk {
    std::uint32_t tiles_x = 0;          ///< tiles per row
    std::vector<TerrainTile> tiles;     ///< used for heights of 1 and 2 bytes
    std::vector<std::byte> samples;     ///< tile by tile
    std::vector<std::uint64_t> falling; ///< a bit per cell, 64 per row; empty: all cells have the same diagonal
};

/// The heights of a terrain that is in memory in part: a chunk of 64 by 64 heights is read when one of them is first
/// used. Many threads may do so at once. A derived class reads the chunks.
class TerrainChunks {
public:
    static constexpr std::uint32_t side = 64; ///< heights, or cells, per side of a chunk

    virtual ~TerrainChunks() = default;

    double height(std::uint32_t column, std::uint32_t row) const
    {
        constexpr std::uint32_t tile = Terrain::tile;
        const TerrainChunk& chunk = at(std::size_t(row / side) * across_ + column / side);
        const std::uint32_t number = row % side / tile * chunk.tiles_x + column % side / tile;
        double height;
        decode(outline_, chunk, number, row % tile * tile + column % tile, 1, &height);
        return height;
    }
    /// The heights of columns [from, to) in a row.
    void read_row(std::uint32_t row, std::uint32_t from, std::uint32_t to, double* out) const;
    CellDiagonal diagonal(std::uint32_t x, std::uint32_t y) const
    {
        const TerrainChunk& chunk = at(std::size_t(y / side) * across_ + x / side);
        return chunk.falling[y % side] >> x % side & 1 ? CellDiagonal::falling : CellDiagonal::rising;
    }
    /// Marks the chunk that begins at the corner of a block of cells as used.
    void mark(std::uint32_t x, std::uint32_t y) const { clock_.mark(needed_[std::size_t(y) * across_ + x]); }
    virtual void need_all() const = 0; ///< Throws ChunkFault
    virtual std::size_t bytes() const = 0;

    /// Heights k to k + count - 1 of a tile.
    /// @param terrain  the terrain of which it is a chunk; its heights are not used
    static void decode(const Terrain& terrain, const TerrainChunk& chunk, std::uint32_t tile, std::uint32_t k,
                       std::uint32_t count, double* out);

protected:
    /// Keeps references to both.
    /// @param outline  a terrain without its heights
    TerrainChunks(const Terrain& outline, const ChunkClock& clock);
    const TerrainChunk& at(std::size_t chunk) const
    {
        ONCOLLIDE_ASSERT(chunk < chunks_.size());
        const TerrainChunk* there = chunks_[chunk].load(std::memory_order_acquire);
        clock_.mark(needed_[chunk]);
        return there ? *there : need(chunk);
    }
    /// Reads a chunk, unless another thread has just done so.
    virtual const TerrainChunk& need(std::size_t chunk) const = 0;

    mutable std::vector<std::atomic<const TerrainChunk*>> chunks_;
    mutable std::vector<std::atomic<std::uint64_t>> needed_;

private:
    template <class Sample>
    static void decode_as(const Terrain& terrain, const TerrainChunk& chunk, std::uint32_t tile, std::uint32_t k,
                          std::uint32_t count, double* out);

    const Terrain& outline_;
    const ChunkClock& clock_;
    const std::uint32_t across_; ///< number of chunks in a row
};

} // namespace oncollide
