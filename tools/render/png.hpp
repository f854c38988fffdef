#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace oncollide::tools {

/// Red, green and blue of each pixel, rows from the top.
struct Image {
    int width, height;
    std::vector<std::uint8_t> pixels;
};

/// The bytes of a PNG file.
std::string packed_png(const Image& image);

/// Writes `image` whole or not at all; "-" is standard output. Throws Error{cannot_write}.
void save_png(const Image& image, const std::filesystem::path& path);

} // namespace oncollide::tools
