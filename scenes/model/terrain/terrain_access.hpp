#pragma once
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include <oncollide/base/memory/large_vector.hpp>
#include <oncollide/scenes/model/terrain.hpp>

namespace oncollide {

/// The stored heights of a tile are unit (base + (q << shift)).
struct TerrainTile {
    std::int32_t base = 0;
    std::uint32_t shift = 0;

    std::int32_t at(std::uint32_t q) const
    {
        return static_cast<std::int32_t>(static_cast<std::uint32_t>(base) + (q << shift));
    }
};

/// The heights and diagonals of a terrain in memory.
struct TerrainHeights {
    std::vector<std::uint64_t> falling; ///< a bit per cell; empty: all cells have the same diagonal
    std::vector<TerrainTile> tiles;     ///< used for heights of 1 and 2 bytes
    std::variant<LargeVector<std::uint8_t>, LargeVector<std::uint16_t>, LargeVector<float>, LargeVector<double>>
        samples; ///< tile by tile
};

/// Terrain's arithmetic inline, for the library's own loops. The public header has only declarations: a program could
/// compile inline arithmetic with -ffast-math, and the linker could then give that code to the library.
struct TerrainAccess {
    /// The chunks of a terrain in a cooked file, which are read on first use, so that access may throw ChunkFault;
    /// null: the whole terrain is in memory.
    static TerrainChunks* chunks(const Terrain& t) { return t.chunks_.get(); }
    static double x(const Terrain& t, std::uint32_t column) { return t.origin_.x() + column * t.spacing_.x(); }
    static double y(const Terrain& t, std::uint32_t row) { return t.origin_.y() + row * t.spacing_.y(); }
    static Eigen::Vector3d point(const Terrain& t, std::uint32_t column, std::uint32_t row)
    {
        return {x(t, column), y(t, row), t.origin_.z() + height(t, column, row)};
    }
    static double height(const Terrain& t, std::uint32_t column, std::uint32_t row)
    {
        if (t.chunks_) return height_in_chunk(t, column, row);
        return std::visit([&](const auto& samples) { return height(t, samples, column, row); }, t.heights_->samples);
    }
    /// Calls work(decode), where decode(column, row) is height(): chooses the storage type once for several heights.
    template <class Work>
    static void with_heights(const Terrain& t, Work work)
    {
        if (t.chunks_)
            return work([&](std::uint32_t column, std::uint32_t row) { return height_in_chunk(t, column, row); });
        std::visit(
            [&](const auto& samples) {
                work([&](std::uint32_t column, std::uint32_t row) { return height(t, samples, column, row); });
            },
            t.heights_->samples);
    }
    /// The index of a height in the samples.
    static std::size_t place(const Terrain& t, std::uint32_t column, std::uint32_t row)
    {
        constexpr std::uint32_t tile = Terrain::tile;
        return (std::size_t(row / tile) * t.tiles_x_ + column / tile) * (tile * tile) + row % tile * tile +
               column % tile;
    }
    static CellDiagonal diagonal(const Terrain& t, std::uint32_t x, std::uint32_t y)
    {
        if (!t.mixed_) return t.diagonal_;
        if (t.chunks_) return diagonal_in_chunk(t, x, y);
        const std::uint64_t cell = std::uint64_t(y) * t.cells_x() + x;
        return t.heights_->falling[cell / 64] >> cell % 64 & 1 ? CellDiagonal::falling : CellDiagonal::rising;
    }
    /// A terrain that reads its heights and diagonals from chunks.
    static Terrain in_chunks(Terrain outline, std::shared_ptr<TerrainChunks> chunks)
    {
        outline.chunks_ = std::move(chunks);
        return outline;
    }

private:
    static double height_in_chunk(const Terrain& t, std::uint32_t column, std::uint32_t row);
    static CellDiagonal diagonal_in_chunk(const Terrain& t, std::uint32_t x, std::uint32_t y);
    template <class Sample>
    static double height(const Terrain& t, const LargeVector<Sample>& samples, std::uint32_t column, std::uint32_t row)
    {
        const std::size_t at = place(t, column, row);
        const Sample q = samples[at];
        if constexpr (std::is_floating_point_v<Sample>) {
            return q;
        } else {
            if (q == std::numeric_limits<Sample>::max()) return std::numeric_limits<double>::quiet_NaN();
            return t.unit_ * static_cast<double>(t.heights_->tiles[at / (Terrain::tile * Terrain::tile)].at(q));
        }
    }
};

} // namespace oncollide
