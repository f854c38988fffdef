#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace oncollide {

/// The type of a number in an array.
struct SampleType {
    char kind;        ///< 'u', 'i', 'f'
    std::size_t size; ///< bytes
    bool big;         ///< big-endian
};

/// In NumPy's notation: "<i2", "|u1", ">f8". Throws Error{bad_data} prefixed with `name`.
SampleType sample_type(const std::string& name, std::string_view text);
/// All numbers of `bytes`, whose length is a multiple of the size.
std::vector<double> decoded(const SampleType& type, std::string_view bytes);

} // namespace oncollide
