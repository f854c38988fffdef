#include <algorithm>
#include <array>
#include <memory>

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC // so that programs that link stb themselves can link this library
#define STBI_ONLY_PNG
#define STBI_NO_STDIO
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wunused-but-set-variable"
#include <stb/stb_image.h>
#pragma GCC diagnostic pop

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/files/terrain/height_raster.hpp>

namespace oncollide {

namespace {

std::uint32_t number_at(std::string_view bytes, std::size_t at)
{
    std::uint32_t number = 0;
    for (std::size_t i = 0; i < 4; ++i) number = number << 8 | static_cast<unsigned char>(bytes[at + i]);
    return number;
}

/// Source: PNG specification, annex D.
std::uint32_t crc_of(std::string_view bytes)
{
    static const auto table = [] {
        std::array<std::uint32_t, 256> of;
        for (std::uint32_t n = 0; n < 256; ++n) {
            std::uint32_t c = n;
            for (int k = 0; k < 8; ++k) c = c & 1 ? 0xedb88320 ^ c >> 1 : c >> 1;
            of[n] = c;
        }
        return of;
    }();
    std::uint32_t c = 0xffffffff;
    for (const char byte : bytes) c = table[(c ^ static_cast<unsigned char>(byte)) & 0xff] ^ c >> 8;
    return ~c;
}

/// Needed because stb accepts files that are cut or damaged. Returns the number of bytes of compressed rows.
std::uint64_t check_chunks(const std::string& name, std::string_view bytes)
{
    std::uint64_t rows = 0;
    for (std::size_t at = 8;;) {
        if (bytes.size() - at < 12 || number_at(bytes, at) > bytes.size() - at - 12)
            refuse(name, "the file is cut off");
        const std::size_t length = number_at(bytes, at);
        const std::string_view type = bytes.substr(at + 4, 4);
        if (crc_of(bytes.substr(at + 4, length + 4)) != number_at(bytes, at + 8 + length))
            refuse(name, fmt::format("the chunk at byte {} is damaged: its checksum is wrong", at));
        if (type == "IDAT") rows += length;
        if (type == "IEND") return rows;
        at += 12 + length;
    }
}

} // namespace

HeightRaster read_grey_png(const std::string& name, std::string_view bytes)
{
    if (!bytes.starts_with("\x89PNG\r\n\x1a\n")) refuse(name, "not a PNG file");
    if (bytes.size() < 33 || bytes.substr(12, 4) != "IHDR") refuse(name, "the file is cut off");
    HeightRaster raster;
    raster.columns = number_at(bytes, 16), raster.rows = number_at(bytes, 20);
    const int bits = bytes[24], colour = bytes[25];
    if (colour != 0 || (bits != 8 && bits != 16))
        refuse(name, fmt::format("a PNG of colour type {} and {} bits; heights are grey (type 0), of 8 or 16 bits",
                                 colour, bits));
    // Deflate compresses at most 1032 bytes into one; a small file must still not fill the memory.
    constexpr std::uint64_t most_of_small_files = 20'000'000, most_a_byte = 64;
    const std::uint64_t packed = check_chunks(name, bytes), samples = std::uint64_t(raster.columns) * raster.rows;
    if (samples == 0 || samples / 1032 > packed || bytes.size() > 0x7fffffff)
        refuse(name, fmt::format("{} x {} heights are announced; {} bytes cannot hold them", raster.columns,
                                 raster.rows, packed));
    if (samples > std::max(most_of_small_files, most_a_byte * packed))
        refuse(name, fmt::format("{} heights in {} bytes; at most {}, or {} a byte, are allowed", samples, packed,
                                 most_of_small_files, most_a_byte));
    int width = 0, height = 0, channels = 0;
    const auto* data = reinterpret_cast<const stbi_uc*>(bytes.data());
    const auto size = static_cast<int>(bytes.size());
    const auto read = [&](auto* pixels) {
        const std::unique_ptr<std::remove_pointer_t<decltype(pixels)>, void (*)(void*)> owner(pixels, stbi_image_free);
        if (!pixels) refuse(name, fmt::format("cannot be read as a PNG: {}", stbi_failure_reason()));
        raster.heights.assign(pixels, pixels + samples);
    };
    if (bits == 16)
        read(stbi_load_16_from_memory(data, size, &width, &height, &channels, 1));
    else
        read(stbi_load_from_memory(data, size, &width, &height, &channels, 1));
    raster.whole = true;
    return raster;
}

} // namespace oncollide
