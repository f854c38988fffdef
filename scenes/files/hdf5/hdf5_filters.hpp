#pragma once
#include <span>
#include <string>

#include <oncollide/scenes/files/hdf5/hdf5_layout.hpp>

namespace oncollide {

/// Undoes the filters of a chunk. Throws Hdf5Fault if the result does not have `size` bytes. Private to scenes.
/// @param skipped  filters that were not used, one bit each
/// @param stored   the bytes in the file; overwritten
void undo_hdf5_filters(std::span<const Hdf5Filter> filters, std::uint32_t skipped, std::string& stored,
                       std::string& out, std::uint64_t size);

/// The most bytes that filters can make of stored bytes.
constexpr std::uint64_t hdf5_most_unfiltered(std::uint64_t stored)
{
    constexpr std::uint64_t ratio = 1032; // largest ratio of deflate
    return stored > hdf5_nowhere / 2 / ratio ? hdf5_nowhere / 2 : ratio * stored;
}

} // namespace oncollide
