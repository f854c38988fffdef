#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <oncollide/scenes/cooked/cooked_file.hpp>
#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// What can be said of a cooked mesh before anything of its file is read, because an index of tiles repeats it.
struct CookedOutline {
    Aabb bounds;
    double radius = 0; ///< around the bounds' centre, of the triangles' corners
    std::uint64_t triangles = 0, vertices = 0, zero_area = 0;
    std::uint64_t header_checksum = 0;

    friend bool operator==(const CookedOutline& a, const CookedOutline& b)
    {
        return a.bounds.min == b.bounds.min && a.bounds.max == b.bounds.max && a.radius == b.radius &&
               a.triangles == b.triangles && a.vertices == b.vertices && a.zero_area == b.zero_area &&
               a.header_checksum == b.header_checksum;
    }
};

/// Why no mesh can be like this; null: one can.
const char* why_not_outline(const CookedOutline& outline);

/// A mesh in a cooked file (docs/cooked.md), of which only the top is read: its bounds, what is known of it, the upper
/// levels of its tree. The triangles lie in chunks, each of which is checked as a whole when it is read: the checksum,
/// every index, every coordinate. Of a tile not even the top is read before somebody needs it, and it is given back
/// when nobody does any more.
///
/// Const calls are safe from many threads at once.
class CookedMesh {
public:
    /// Throws Error{no_input} when the file cannot be read, Error{bad_data} when it is no cooked mesh, of another
    /// version or byte order, damaged or cut off. Cost: reading the top, 35 bytes for each thousand triangles.
    explicit CookedMesh(const std::filesystem::path& path);
    /// A tile: the file is not touched. What is called below throws ChunkFault where it cannot be read, or contradicts
    /// the outline, when that is first found out, and from then on always the same.
    CookedMesh(const std::filesystem::path& path, const CookedOutline& outline);
    ~CookedMesh();
    CookedMesh(const CookedMesh&) = delete;
    CookedMesh& operator=(const CookedMesh&) = delete;

    const std::string& name() const; ///< the path, for errors
    const CookedOutline& outline() const { return outline_; }
    const Aabb& bounds() const { return outline_.bounds; }
    std::size_t triangles() const { return outline_.triangles; }
    std::size_t vertices() const { return outline_.vertices; } ///< with those that no triangle uses
    std::size_t zero_area() const { return outline_.zero_area; }
    double radius() const { return outline_.radius; }
    /// Was the file found to have other bounds than the outline says? Then nothing may rest on these.
    bool contradicts_outline() const { return contradicts_.load(std::memory_order_relaxed); }

    using Part = CookedPart;
    std::optional<bool> closed() const { return open()->closed; }            ///< nothing: the file does not say
    std::optional<std::vector<Part>> parts() const { return open()->parts; } ///< nothing: the file does not say
    std::size_t chunks() const { return open()->chunks.size(); }

    /// What is held of the file while it is used.
    struct Top {
        std::shared_ptr<const CookedFile::Handle> file;
        std::uint32_t coordinate_bytes = 0;
        std::optional<bool> closed;
        std::optional<std::vector<Part>> parts;
        /// Nodes of the tree's upper levels, 288 bytes each, as the file has them: not checked here.
        std::vector<std::byte> nodes;
        /// Of these the first `tree_chunks` are the leaves of the upper levels, in the order of the tree; others hold
        /// vertices that no triangle uses.
        std::vector<CookedChunkEntry> chunks;
        std::size_t tree_chunks = 0;

        std::size_t bytes() const;
    };
    /// The top, to be held while it is used.
    std::shared_ptr<const Top> open() const;
    bool is_open() const; ///< does anybody hold it?

    struct Chunk {
        std::vector<Eigen::Vector3d> vertices;
        std::vector<std::uint32_t> vertex_numbers; ///< in the source
        std::vector<Triangle> triangles;           ///< of these vertices
        std::vector<std::uint32_t> numbers;        ///< in the source
    };
    /// Throws ChunkFault, from then on for this chunk always the same.
    void read(std::size_t chunk, Chunk& out) const;
    /// Records that a chunk contradicts the top. Throws the ChunkFault.
    [[noreturn]] void refuse_chunk(std::size_t chunk, const std::string& why) const;
    /// What went wrong since the file was opened, a line for each chunk.
    std::vector<std::string> faults() const;

    /// The mesh as it was cooked, in the order of the source. Throws ChunkFault.
    Mesh whole() const;

    const CookedFile& file() const { return *file_; }

private:
    Top read_file(CookedOutline& outline) const;
    void take_table(Top& top, const CookedOutline& outline, const CookedFile::Opened& opened) const;
    void unpack(const Top& top, std::size_t chunk, std::span<const std::byte> bytes, Chunk& out) const;

    std::unique_ptr<const CookedFile> file_;
    CookedOutline outline_;
    std::shared_ptr<const Top> kept_;       ///< null: a tile
    mutable std::weak_ptr<const Top> open_; ///< of a tile
    mutable std::atomic<bool> contradicts_ = false;
    mutable std::mutex mutex_;
};

/// Is it one by its name? Cooked files end in `.cooked`.
bool is_cooked(const std::filesystem::path& path);

} // namespace oncollide
