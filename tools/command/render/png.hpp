#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <oncollide/narrowphase/gl/picture.hpp>

namespace oncollide::tools {

/// Red, green and blue of each pixel, rows from the top.
struct Image {
    int width, height;
    std::vector<std::uint8_t> pixels;

    void set(int x, int y, Colour colour)
    {
        std::uint8_t* const at = &pixels[3 * (std::size_t(y) * std::size_t(width) + std::size_t(x))];
        at[0] = colour.red, at[1] = colour.green, at[2] = colour.blue;
    }
};

/// A white image.
Image blank(int width, int height);
/// Copies an image of `width` columns and as many rows as `into` to `into`, from `column` on.
void paste(std::span<const std::uint8_t> pixels, int width, Image& into, int column);

/// The bytes of a PNG file.
std::string packed_png(const Image& image);

/// Writes `image` whole or not at all; "-" is standard output. Throws Error{cannot_write}.
void save_png(const Image& image, const std::filesystem::path& path);

} // namespace oncollide::tools
