#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace oncollide {

// What the readers of files of heights share. Private to scenes.

/// The heights of a file, in its units, row by row.
struct HeightRaster {
    std::uint32_t columns = 0, rows = 0;
    std::vector<double> heights;
    bool whole = false; ///< whole numbers, by their type
    std::optional<Eigen::Vector2d> spacing{};
    std::optional<double> no_data{};
};

/// A number as arrays store it.
struct SampleType {
    char kind;        ///< 'u', 'i', 'f'
    std::size_t size; ///< bytes
    bool big;         ///< the most significant byte is the first
};

/// As NumPy writes it: "<i2", "|u1", ">f8". Throws Error{bad_data} that begins with `name`.
SampleType sample_type(const std::string& name, std::string_view text);
/// All numbers of `bytes`, whose length is a multiple of the size.
std::vector<double> decoded(const SampleType& type, std::string_view bytes);
/// Throws Error{bad_data} unless there are as many bytes as such a grid takes. Nothing overflows.
void check_size(const std::string& name, std::uint64_t columns, std::uint64_t rows, std::size_t size,
                std::uint64_t bytes);

// One reader a format: what it allocates is bounded by the size of the file. `name` begins every message.
HeightRaster read_pgm(const std::string& name, std::string_view bytes);
HeightRaster read_grey_png(const std::string& name, std::string_view bytes);
HeightRaster read_npy(const std::string& name, std::string_view bytes);
/// Row 0 is the southernmost.
HeightRaster read_with_gdal(const std::filesystem::path& path);

} // namespace oncollide
