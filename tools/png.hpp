#pragma once
#include <cstdint>
#include <filesystem>
#include <vector>

namespace oncollide::tools {

/// Red, green and blue of each pixel, rows from the top.
struct Image {
    int width, height;
    std::vector<std::uint8_t> pixels;
};

/// Writes `image` whole or not at all; "-" is standard output. Throws Error{cannot_write}.
void save_png(const Image& image, const std::filesystem::path& path);

} // namespace oncollide::tools
