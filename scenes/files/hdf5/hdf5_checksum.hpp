#pragma once
#include <cstdint>
#include <string_view>

namespace oncollide {

// The checksums of HDF5 files. Private to scenes.

/// Of metadata. Source: Bob Jenkins, "lookup3.c", 2006, hashlittle() with the initial value 0.
std::uint32_t hdf5_checksum(std::string_view bytes);

/// Of chunks (filter 3): Fletcher's with sums of 16 bits, over big-endian words.
std::uint32_t fletcher32(std::string_view bytes);

} // namespace oncollide
