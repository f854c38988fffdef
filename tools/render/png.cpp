#include "render/png.hpp"

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

/// Set before threads pack. A longer search gains little.
[[maybe_unused]] const int compression = stbi_write_png_compression_level = 12;

} // namespace

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
