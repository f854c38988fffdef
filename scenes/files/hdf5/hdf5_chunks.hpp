#pragma once
#include <span>
#include <vector>

#include <oncollide/base/function_ref.hpp>
#include <oncollide/scenes/files/hdf5/hdf5_layout.hpp>

namespace oncollide {

// The places of a dataset's chunks. Private to scenes.

struct Hdf5Chunk {
    std::uint64_t number; ///< number in the grid of chunks, the last dimension first
    std::uint64_t address, bytes;
    std::uint32_t skipped; ///< filters that were not used, one bit each
};

/// The chunks of a shape.
class Hdf5Grid {
public:
    Hdf5Grid(const std::vector<std::uint64_t>& extent, const std::vector<std::uint64_t>& edges);

    std::size_t dimensions() const { return counts_.size(); }
    std::uint64_t count(std::size_t dimension) const { return counts_[dimension]; }
    std::uint64_t number(std::span<const std::uint64_t> chunk) const; ///< chunk: its number in each dimension
    bool contains(std::span<const std::uint64_t> chunk) const;

private:
    std::vector<std::uint64_t> counts_;
};

/// The chunks that are in the file, sorted by number.
/// @param chunk_bytes  the size of a chunk without filters
std::vector<Hdf5Chunk> hdf5_chunks(Hdf5Walk& walk, const Hdf5Layout& layout, const Hdf5Space& space,
                                   const Hdf5Grid& grid, std::uint64_t chunk_bytes);

/// An element of an array of chunks: its number there, and its bytes.
using VisitHdf5Element = FunctionRef<void(std::uint64_t number, Hdf5Cursor element)>;
void walk_fixed_array(Hdf5Walk& walk, std::uint64_t header, unsigned element_kind, VisitHdf5Element visit);
void walk_extensible_array(Hdf5Walk& walk, std::uint64_t header, unsigned element_kind, VisitHdf5Element visit);

} // namespace oncollide
