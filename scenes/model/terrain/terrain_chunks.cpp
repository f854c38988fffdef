#include <oncollide/scenes/model/terrain/terrain_chunks.hpp>

#include <algorithm>
#include <cstring>
#include <limits>
#include <type_traits>

namespace oncollide {

TerrainChunks::TerrainChunks(const Terrain& outline, const ChunkClock& clock)
    : chunks_(std::size_t((outline.columns() - 1) / side + 1) * ((outline.rows() - 1) / side + 1)),
      needed_(chunks_.size()), outline_(outline), clock_(clock), across_((outline.columns() - 1) / side + 1)
{
}

/// Reads the heights of `count` consecutive positions of a tile.
template <class Sample>
void TerrainChunks::decode_as(const Terrain& terrain, const TerrainChunk& chunk, std::uint32_t number, std::uint32_t k,
                              std::uint32_t count, double* out)
{
    const std::byte* const from =
        &chunk.samples[(std::size_t(number) * Terrain::tile * Terrain::tile + k) * sizeof(Sample)];
    for (std::uint32_t i = 0; i < count; ++i) {
        Sample q;
        std::memcpy(&q, from + i * sizeof q, sizeof q);
        if constexpr (std::is_floating_point_v<Sample>)
            out[i] = static_cast<double>(q);
        else
            out[i] = q == std::numeric_limits<Sample>::max()
                         ? std::numeric_limits<double>::quiet_NaN()
                         : terrain.unit_ * static_cast<double>(chunk.tiles[number].at(q));
    }
}

void TerrainChunks::decode(const Terrain& terrain, const TerrainChunk& chunk, std::uint32_t number, std::uint32_t k,
                           std::uint32_t count, double* out)
{
    switch (terrain.bytes_per_height()) {
    case 1:
        return decode_as<std::uint8_t>(terrain, chunk, number, k, count, out);
    case 2:
        return decode_as<std::uint16_t>(terrain, chunk, number, k, count, out);
    case 4:
        return decode_as<float>(terrain, chunk, number, k, count, out);
    default:
        return decode_as<double>(terrain, chunk, number, k, count, out);
    }
}

void TerrainChunks::read_row(std::uint32_t row, std::uint32_t from, std::uint32_t to, double* out) const
{
    constexpr std::uint32_t tile = Terrain::tile;
    ONCOLLIDE_ASSERT(row < outline_.rows() && from <= to && to <= outline_.columns());
    while (from < to) {
        const TerrainChunk& chunk = at(std::size_t(row / side) * across_ + from / side);
        const std::uint32_t end = std::min(to, (from / tile + 1) * tile);
        decode(outline_, chunk, row % side / tile * chunk.tiles_x + from % side / tile, row % tile * tile + from % tile,
               end - from, out);
        out += end - from, from = end;
    }
}

} // namespace oncollide
