#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <oncollide/scenes/files/common/sample_type.hpp>

namespace oncollide {

/// The header of a NumPy array. Private to scenes.
struct NpyHeader {
    SampleType type;
    bool columns_first;
    std::vector<std::uint64_t> shape; ///< empty if it is not a list of numbers
    std::string shape_text;           ///< for errors
    std::size_t bytes;                ///< offset of the numbers
};

/// Reads it from the first bytes of a file. Throws Error{bad_data} that begins with `name`.
NpyHeader read_npy_header(const std::string& name, std::string_view bytes);

/// The first bytes of a file of numbers of this NumPy type, such as "<f8", in the order of C.
/// @param shape  two sides or more
std::string npy_header(std::string_view type, std::span<const std::uint64_t> shape);

} // namespace oncollide
