#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace oncollide {

// Shared by the readers of height files. Private to scenes.

/// The heights of a file, in its units, row by row.
struct HeightRaster {
    std::uint32_t columns = 0, rows = 0;
    std::vector<double> heights;
    bool whole = false; ///< integers, by their type
    std::optional<Eigen::Vector2d> spacing{};
    std::optional<double> no_data{};
};

/// Throws Error{bad_data} unless the number of bytes matches such a grid. Safe from overflow.
void check_size(const std::string& name, std::uint64_t columns, std::uint64_t rows, std::size_t size,
                std::uint64_t bytes);

// One reader per format; allocations are bounded by the size of the file. Messages begin with `name`.
HeightRaster read_pgm(const std::string& name, std::string_view bytes);
HeightRaster read_grey_png(const std::string& name, std::string_view bytes);
HeightRaster read_npy(const std::string& name, std::string_view bytes);
/// Row 0 is the southernmost.
HeightRaster read_with_gdal(const std::filesystem::path& path);

} // namespace oncollide
