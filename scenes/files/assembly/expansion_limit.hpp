#pragma once
#include <atomic>
#include <cstdint>
#include <limits>

#include <oncollide/scenes/files/mesh/mesh_source.hpp>

namespace oncollide {

/// A few bytes may place a mesh a million times, so the result's size is limited: by the bytes of all files, since a
/// file without repetition needs at least a byte per triangle and per vertex, or by a number that is allowed for any
/// file; and by the number of parts. Private to scenes.
class ExpansionLimit {
public:
    static constexpr std::size_t any_parts = std::numeric_limits<std::size_t>::max(); ///< most parts for a whole mesh

    /// @param most_parts  the limit of PartsReading
    ExpansionLimit(const MeshSource& source, std::size_t most_parts) : source_(source), most_parts_(most_parts) {}

    /// Throws Error{bad_data} if all threads together spent too many pieces: triangles, vertices and parts of meshes.
    /// @param beside bytes of other files that were read
    void spend(std::uint64_t pieces, std::uint64_t beside = 0);
    /// Throws as spend(), but spends nothing: refuses work before it begins.
    void expect(std::uint64_t pieces) const { check(spent_ + pieces, 0); }
    /// Adds parts. Throws Error{bad_data} if all calls together add too many.
    /// @param written the file's own nodes and instances: a file may have as many parts as it writes
    void expect_parts(std::uint64_t parts, std::uint64_t written);

private:
    void check(std::uint64_t spent, std::uint64_t beside) const;

    const MeshSource& source_;
    const std::uint64_t most_parts_;
    std::uint64_t parts_ = 0, written_ = 0;
    std::atomic<std::uint64_t> spent_ = 0;
};

} // namespace oncollide
