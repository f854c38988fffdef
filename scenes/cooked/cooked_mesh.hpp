#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <oncollide/base/threads/lock_order.hpp>
#include <oncollide/scenes/cooked/cooked_file.hpp>
#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// Properties of a cooked mesh that an index of tiles repeats, so that they are known before the file is read.
struct CookedOutline {
    Aabb bounds;
    double radius = 0; ///< radius of the sphere around the bounds' centre that contains the triangles' corners
    std::uint64_t triangles = 0, vertices = 0, zero_area = 0;
    std::uint64_t header_checksum = 0;

    friend bool operator==(const CookedOutline& a, const CookedOutline& b)
    {
        return a.bounds.min == b.bounds.min && a.bounds.max == b.bounds.max && a.radius == b.radius &&
               a.triangles == b.triangles && a.vertices == b.vertices && a.zero_area == b.zero_area &&
               a.header_checksum == b.header_checksum;
    }
};

/// Returns why no mesh can have this outline; null: a mesh can.
const char* why_not_outline(const CookedOutline& outline);

/// A mesh in a cooked file (docs/cooked.md), of which only the top is read: its bounds, its properties, the upper
/// levels of its tree. The triangles are in chunks, each of which is checked as a whole when it is read: the checksum,
/// every index, every coordinate. The top of a tile is read on first use, and released when its last user releases it.
///
/// Const calls are safe from many threads at once.
class CookedMesh {
public:
    /// Throws Error{no_input} if the file cannot be read, Error{bad_data} if it is not a cooked mesh, has another
    /// version or byte order, or is damaged or cut off. Cost: reading the top, 35 bytes per thousand triangles.
    explicit CookedMesh(const std::filesystem::path& path);
    /// Makes a tile; does not access the file. The functions below throw ChunkFault if the file cannot be read or
    /// contradicts the outline; after the first such error, they always throw the same error.
    CookedMesh(const std::filesystem::path& path, const CookedOutline& outline);
    ~CookedMesh();
    CookedMesh(const CookedMesh&) = delete;
    CookedMesh& operator=(const CookedMesh&) = delete;

    const std::string& name() const; ///< the path, for errors
    const CookedOutline& outline() const { return outline_; }
    const Aabb& bounds() const { return outline_.bounds; }
    std::size_t triangles() const { return outline_.triangles; }
    std::size_t vertices() const { return outline_.vertices; } ///< including vertices that no triangle uses
    std::size_t zero_area() const { return outline_.zero_area; }
    double radius() const { return outline_.radius; }
    /// True if the file was found to have other bounds than the outline. No result may then rely on the outline's
    /// bounds.
    bool contradicts_outline() const { return contradicts_.load(std::memory_order_relaxed); }

    using Part = CookedPart;
    std::optional<bool> closed() const { return open()->closed; }            ///< empty: the file does not say
    std::optional<std::vector<Part>> parts() const { return open()->parts; } ///< empty: the file does not say
    std::size_t chunks() const { return open()->chunks.size(); }

    /// The part of the file that is held in memory while it is used.
    struct Top {
        std::shared_ptr<const CookedFile::Handle> file;
        std::uint32_t coordinate_bytes = 0;
        std::optional<bool> closed;
        std::optional<std::vector<Part>> parts;
        /// Nodes of the tree's upper levels, 288 bytes each, as stored in the file: not checked here.
        std::vector<std::byte> nodes;
        /// The first `tree_chunks` chunks are the leaves of the upper levels, in the order of the tree; the others hold
        /// vertices that no triangle uses.
        std::vector<CookedChunkEntry> chunks;
        std::size_t tree_chunks = 0;

        std::size_t bytes() const;
    };
    /// The top; the caller holds it while it uses it.
    std::shared_ptr<const Top> open() const;
    bool is_open() const; ///< true if a caller holds the top

    struct Chunk {
        std::vector<Eigen::Vector3d> vertices;
        std::vector<std::uint32_t> vertex_numbers; ///< in the source
        std::vector<Triangle> triangles;           ///< triangles of the chunk's vertices
        std::vector<std::uint32_t> numbers;        ///< in the source
    };
    /// Throws ChunkFault; later calls for this chunk throw the same error.
    void read(std::size_t chunk, Chunk& out) const;
    /// Records that a chunk contradicts the top. Throws the ChunkFault.
    [[noreturn]] void refuse_chunk(std::size_t chunk, const std::string& why) const;
    /// The faults since the file was opened, one line per chunk.
    std::vector<std::string> faults() const;

    /// The mesh as it was before cooking, in the order of the source. Throws ChunkFault.
    Mesh whole() const;

    const CookedFile& file() const { return *file_; }

private:
    Top read_file(CookedOutline& outline) const;
    void take_table(Top& top, const CookedOutline& outline, const CookedFile::Opened& opened) const;
    void unpack(const Top& top, std::size_t chunk, std::span<const std::byte> bytes, Chunk& out) const;

    std::unique_ptr<const CookedFile> file_;
    CookedOutline outline_;
    std::shared_ptr<const Top> kept_;       ///< null: a tile
    mutable std::weak_ptr<const Top> open_; ///< the top of a tile
    mutable std::atomic<bool> contradicts_ = false;
    mutable OrderedMutex<LockRank::cooked_mesh> mutex_;
};

/// Whether the name ends in `.cooked`.
bool is_cooked(const std::filesystem::path& path);

} // namespace oncollide
