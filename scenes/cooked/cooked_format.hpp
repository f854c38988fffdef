// What a cooked file consists of: docs/cooked.md, "The format". Private to those who read and write such files.
#pragma once
#include <cstdint>

namespace oncollide {

constexpr char cooked_magic[8] = {'o', 'n', 'c', 'o', 'o', 'k', 'e', 'd'};
constexpr std::uint32_t cooked_byte_order = 0x01020304;
/// Of the format and of the trees in it: to be raised whenever ObbTree parts triangles in another way, too.
constexpr std::uint32_t cooked_version = 1;

enum class CookedKind : std::uint32_t { mesh = 1 };
enum class CookedTopology : std::uint32_t { unknown = 0, open = 1, closed = 2 };

/// At the beginning of the file. Followed by the top (nodes, table of chunks, parts) and then the chunks, without gaps.
struct CookedHeader {
    char magic[8];
    std::uint32_t byte_order, version;
    CookedKind kind;
    std::uint32_t coordinate_bytes; ///< 4: all coordinates are floats; 8: doubles
    std::uint64_t file_bytes;
    std::uint64_t triangles, vertices, zero_area; ///< of the source
    double low[3], high[3];                       ///< its bounds
    double radius;                                ///< of the tree
    CookedTopology topology;
    std::uint32_t parts_known; ///< 1: the points of all `parts` are in the top
    std::uint64_t parts;
    std::uint32_t nodes, chunks;
    std::uint64_t top_checksum;
    std::uint64_t header_checksum; ///< of all that stands before it
};
static_assert(sizeof(CookedHeader) == 152);

/// A chunk, as the table has it. Its data: vertices (three coordinates each), their numbers in the source (4 bytes),
/// the triangles' corners among the chunk's vertices (three times 2 bytes), their numbers in the source (4 bytes), and
/// zeros up to a multiple of 8 bytes.
struct CookedChunkEntry {
    std::uint64_t offset, bytes, checksum;
    std::uint32_t triangles, vertices;
};
static_assert(sizeof(CookedChunkEntry) == 32);

constexpr std::uint32_t cooked_node_bytes = 288;       ///< of a node of the top (BoxNode)
constexpr std::uint32_t cooked_part_bytes = 6 * 3 * 8; ///< of a part: six points
constexpr std::uint32_t most_chunk_triangles = 8192;   ///< of a chunk
constexpr std::uint32_t most_chunk_vertices = 3 * most_chunk_triangles;

/// Of a chunk's data.
constexpr std::uint64_t chunk_bytes(std::uint64_t triangles, std::uint64_t vertices, std::uint64_t coordinate_bytes)
{
    return (vertices * (3 * coordinate_bytes + 4) + triangles * 10 + 7) / 8 * 8;
}

} // namespace oncollide
