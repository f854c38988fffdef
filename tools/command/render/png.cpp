#include "render/png.hpp"

#include <algorithm>
#include <string_view>

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC // programs that link stb themselves can link this, too
#define STBI_WRITE_NO_STDIO
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image_write.h>
#pragma GCC diagnostic pop

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/output_file.hpp>

namespace oncollide::tools {

namespace {

/// Must be set before threads pack pictures. A longer search gains little.
[[maybe_unused]] const int compression = stbi_write_png_compression_level = 12;

} // namespace

Image blank(int width, int height)
{
    return {width, height, std::vector<std::uint8_t>(3 * std::size_t(width) * std::size_t(height), 255)};
}

void paste(std::span<const std::uint8_t> pixels, int width, Image& into, int column)
{
    const auto row = std::ptrdiff_t(3 * width), whole = std::ptrdiff_t(3 * into.width);
    for (int y = 0; y < into.height; ++y)
        std::copy_n(pixels.begin() + row * y, row, into.pixels.begin() + whole * y + 3 * column);
}

std::string packed_png(const Image& image)
{
    std::string bytes;
    const auto write = [](void* to, void* data, int size) {
        static_cast<std::string*>(to)->append(static_cast<const char*>(data), static_cast<std::size_t>(size));
    };
    if (!stbi_write_png_to_func(write, &bytes, image.width, image.height, 3, image.pixels.data(), 3 * image.width))
        throw Error(ErrorKind::internal, "out of memory while packing a picture");
    return bytes;
}

void save_png(const Image& image, const std::filesystem::path& path)
{
    OutputFile file(path);
    file.write(packed_png(image));
    file.commit();
}

} // namespace oncollide::tools
