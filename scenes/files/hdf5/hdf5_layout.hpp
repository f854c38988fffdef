#pragma once
#include <optional>
#include <string>
#include <vector>

#include <oncollide/scenes/files/hdf5/hdf5_object.hpp>

namespace oncollide {

// The header of a dataset: its shape, and where its data is. Private to scenes.

constexpr unsigned hdf5_most_dimensions = 32;

struct Hdf5Space {
    std::vector<std::uint64_t> extent, most; ///< most: hdf5_nowhere for unlimited dimensions
};

struct Hdf5Filter {
    enum Kind : std::uint16_t { deflate = 1, shuffle = 2, fletcher = 3 };
    std::uint16_t kind;
    std::uint32_t value; ///< shuffle: bytes of a number
};

struct Hdf5Layout {
    enum class Kind { compact, contiguous, old_btree, single, implicit, fixed_array, extensible_array, btree };
    Kind kind = Kind::compact;
    std::string data;                     ///< compact
    std::uint64_t address = hdf5_nowhere; ///< address of the data, or of the index of chunks
    std::vector<std::uint64_t> edges;     ///< edges of a chunk
    std::uint64_t value_bytes = 0;        ///< chunks: bytes of a value
    std::optional<std::uint64_t> stored;  ///< single, filtered: bytes in the file
    std::uint32_t skipped = 0;            ///< single: filters that were not used, one bit each
    bool parts_are_unfiltered = false;    ///< chunks that are partly outside the dataset are stored without filters
    std::vector<Hdf5Filter> filters;      ///< in the order of writing
};

Hdf5Space hdf5_space(Hdf5Walk& walk, const Hdf5Object& object);
/// Reads the layout and the filters. Throws Hdf5Fault for data in other files.
Hdf5Layout hdf5_layout(Hdf5Walk& walk, const Hdf5Object& object);
/// The value of numbers that were not written, as `bytes` bytes.
std::string hdf5_fill_value(Hdf5Walk& walk, const Hdf5Object& object, std::uint64_t bytes);

} // namespace oncollide
