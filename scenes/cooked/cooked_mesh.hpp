#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// A part of a cooked file cannot be had: it is damaged, cut off, changed since it was opened, or not to be read. Of
/// `NoRoomForChunk` that only the budget is in the way.
class ChunkFault : public Error {
public:
    using Error::Error;
};
class NoRoomForChunk final : public ChunkFault {
public:
    using ChunkFault::ChunkFault;
};

/// A mesh in a cooked file (docs/cooked.md), of which only the top is read: its bounds, what is known of it, the upper
/// levels of its tree. The triangles lie in chunks, each of which is checked as a whole when it is read: the checksum,
/// every index, every coordinate.
///
/// Const calls are safe from many threads at once.
class CookedMesh {
public:
    /// Throws Error{no_input} when the file cannot be read, Error{bad_data} when it is no cooked mesh, of another
    /// version or byte order, damaged or cut off. Cost: reading the top, 35 bytes for each thousand triangles.
    explicit CookedMesh(const std::filesystem::path& path);
    ~CookedMesh();
    CookedMesh(const CookedMesh&) = delete;
    CookedMesh& operator=(const CookedMesh&) = delete;

    const std::string& name() const { return name_; } ///< the path, for errors
    const Aabb& bounds() const { return bounds_; }
    std::size_t triangles() const { return triangles_; }
    std::size_t vertices() const { return vertices_; } ///< with those that no triangle uses
    std::size_t zero_area() const { return zero_area_; }
    double radius() const { return radius_; }              ///< around the bounds' centre, of the triangles' corners
    std::optional<bool> closed() const { return closed_; } ///< nothing: the file does not say
    using Part = std::array<Eigen::Vector3d, 6>;
    const std::optional<std::vector<Part>>& parts() const { return parts_; } ///< nothing: the file does not say

    /// Nodes of the tree's upper levels, cooked_node_bytes each, as the file has them: not checked here.
    std::span<const std::byte> nodes() const { return nodes_; }

    /// Of these the first tree_chunks() are the leaves of the upper levels, in the order of the tree; others hold
    /// vertices that no triangle uses.
    std::size_t chunks() const { return chunks_.size(); }
    std::size_t tree_chunks() const { return tree_chunks_; }
    std::uint32_t chunk_triangles(std::size_t chunk) const { return chunks_[chunk].triangles; }
    std::uint32_t chunk_vertices(std::size_t chunk) const { return chunks_[chunk].vertices; }

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

    std::size_t bytes() const; ///< held

private:
    struct Entry {
        std::uint64_t offset, bytes, checksum;
        std::uint32_t triangles, vertices;
    };
    class File;
    void read_top(std::span<const std::byte> top, std::uint32_t chunks, std::uint64_t first);
    void unpack(std::size_t chunk, std::span<const std::byte> bytes, Chunk& out) const;
    [[noreturn]] void refuse_file(const std::string& why) const;

    std::string name_;
    std::unique_ptr<File> file_;
    std::uint64_t file_bytes_ = 0;
    std::uint32_t coordinate_bytes_ = 0;
    Aabb bounds_;
    std::size_t triangles_ = 0, vertices_ = 0, zero_area_ = 0;
    double radius_ = 0;
    std::optional<bool> closed_;
    std::optional<std::vector<Part>> parts_;
    std::vector<std::byte> nodes_;
    std::vector<Entry> chunks_;
    std::size_t tree_chunks_ = 0;
    mutable std::mutex mutex_;
    mutable std::map<std::size_t, std::string> faults_; ///< by chunk
};

/// Is it one by its name? Cooked files end in `.cooked`.
bool is_cooked(const std::filesystem::path& path);

} // namespace oncollide
