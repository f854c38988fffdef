// The contents of a cooked file: docs/cooked.md, "The format". Only for code that reads and writes such files.
#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace oncollide {

constexpr char cooked_magic[8] = {'o', 'n', 'c', 'o', 'o', 'k', 'e', 'd'};
constexpr std::uint32_t cooked_byte_order = 0x01020304;
/// Version of the format and of the trees in it: raise it also when ObbTree splits triangles differently.
constexpr std::uint32_t cooked_version = 1;

enum class CookedKind : std::uint32_t { mesh = 1, terrain = 2, map = 3 };
constexpr const char* name_of(CookedKind kind)
{
    return kind == CookedKind::mesh ? "mesh" : kind == CookedKind::terrain ? "terrain" : "map";
}

enum class CookedTopology : std::uint32_t { unknown = 0, open = 1, closed = 2 };

/// The beginning of the file. It is followed by the top (nodes, table of chunks, parts, record) and then the chunks,
/// without gaps.
struct CookedHeader {
    char magic[8];
    std::uint32_t byte_order, version;
    CookedKind kind;
    std::uint32_t coordinate_bytes; ///< 4: all coordinates are floats; 8: doubles
    std::uint64_t file_bytes;
    std::uint64_t triangles, vertices, zero_area; ///< counts of the source; in a map: nodes, then 0
    double low[3], high[3];                       ///< bounds
    double radius;                                ///< radius of the tree
    CookedTopology topology;
    std::uint32_t parts_known; ///< 1: the top contains the points of all `parts`
    std::uint64_t parts;
    std::uint32_t nodes, chunks;
    std::uint64_t top_checksum;
    std::uint64_t header_checksum; ///< checksum of all bytes before this member
};
static_assert(sizeof(CookedHeader) == 152);

/// An entry of the table of chunks. A chunk's data: vertices (three coordinates each), their numbers in the source (4
/// bytes), the triangles' corners as indices into the chunk's vertices (three times 2 bytes), their numbers in the
/// source (4 bytes), and zeros up to a multiple of 8 bytes.
struct CookedChunkEntry {
    std::uint64_t offset, bytes, checksum;
    std::uint32_t triangles, vertices;
};
static_assert(sizeof(CookedChunkEntry) == 32);

/// A node of the upper levels of a mesh's tree: eight OBBs, in the layout of BoxNode.
struct CookedNode {
    std::int16_t x[8], y[8], z[8], qw[8], qx[8], qy[8], qz[8];
    std::uint16_t hx[8], hy[8], hz[8];
    float origin[3], unit;
    std::uint32_t begin[8], count[8], child[8], lanes, leaves, singles, none;
};
static_assert(sizeof(CookedNode) == 288);

/// A terrain without the contents of its chunks. Its nodes are the CookedRange of each block of cells.
struct CookedTerrainRecord {
    std::uint32_t columns, rows;
    double spacing[2], origin[3];
    std::uint32_t least[2], greatest[2]; ///< columns and rows that bound the present cells
    double low, high;                    ///< heights that bound the present cells
    double error, unit;
    std::uint64_t cells;
    std::uint32_t diagonal; ///< 0 rising, 1 falling, 2 each cell has its own
    std::uint32_t holes;    ///< 1: a cell is absent
};
static_assert(sizeof(CookedTerrainRecord) == 112);
/// Bounds of all cells of a block: two heights, and two parallel planes given over the middle of the block; floats,
/// relative to the middle of the bounds.
struct CookedRange {
    float low, high, slab_low, slab_high, slope_x, slope_y;
};

/// A map without the nodes of its octree.
struct CookedMapRecord {
    double resolution;
    std::int32_t low[3], high[3]; ///< bounds, in cells
    std::uint32_t unknown_is_solid;
    std::uint32_t first; ///< first node and masks of the node of the whole grid
    std::uint8_t inner, occupied, free, solid;
    std::uint32_t none; ///< 0
};
static_assert(sizeof(CookedMapRecord) == 48);

/// Bytes of a node of the top: BoxNode, CookedRange, or a node of the octree.
constexpr std::uint32_t cooked_node_bytes(CookedKind kind)
{
    return kind == CookedKind::mesh ? sizeof(CookedNode) : kind == CookedKind::terrain ? sizeof(CookedRange) : 8;
}
constexpr std::uint32_t cooked_part_bytes = 6 * 3 * 8; ///< a part is six points
/// Bytes of the record at the end of the top.
constexpr std::uint32_t cooked_record_bytes(CookedKind kind)
{
    return kind == CookedKind::terrain ? sizeof(CookedTerrainRecord)
           : kind == CookedKind::map   ? sizeof(CookedMapRecord)
                                       : 0;
}

constexpr std::uint32_t most_chunk_triangles = 8192; ///< per chunk
constexpr std::uint32_t most_chunk_vertices = 3 * most_chunk_triangles;
constexpr std::uint32_t most_chunk_nodes = 4096; ///< octree nodes per chunk of a map

/// Bytes of a chunk's data.
constexpr std::uint64_t chunk_bytes(std::uint64_t triangles, std::uint64_t vertices, std::uint64_t coordinate_bytes)
{
    return (vertices * (3 * coordinate_bytes + 4) + triangles * 10 + 7) / 8 * 8;
}

} // namespace oncollide
