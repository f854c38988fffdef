#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstring>

#include <fmt/format.h>
#include <png.h>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/files/terrain/height_raster.hpp>

namespace oncollide {

namespace {

/// libpng over bytes in memory. libpng reports errors by longjmp, so the functions that call setjmp hold no objects
/// with destructors, and return false after an error.
class PngReader {
public:
    explicit PngReader(std::string_view bytes) : bytes_(bytes)
    {
        png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, fail, warn);
        info_ = png_ ? png_create_info_struct(png_) : nullptr;
        if (!info_) {
            png_destroy_read_struct(&png_, nullptr, nullptr);
            throw std::bad_alloc();
        }
    }
    ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }
    PngReader(const PngReader&) = delete;
    PngReader& operator=(const PngReader&) = delete;

    bool read_header()
    {
        if (setjmp(png_jmpbuf(png_))) return false;
        png_set_read_fn(png_, this, read);
        png_set_user_limits(png_, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
        png_set_crc_action(png_, PNG_CRC_ERROR_QUIT, PNG_CRC_ERROR_QUIT);
        png_set_keep_unknown_chunks(png_, PNG_HANDLE_CHUNK_NEVER, nullptr, -1); // only the pixels are needed
        png_read_info(png_, info_);
        return true;
    }
    /// Reads all rows, each of `width` bytes, and the rest of the file for its checksums.
    bool read_rows(png_bytep pixels, std::size_t width)
    {
        if (setjmp(png_jmpbuf(png_))) return false;
        const int passes = png_set_interlace_handling(png_);
        png_read_update_info(png_, info_);
        for (int pass = 0; pass < passes; ++pass)
            for (std::size_t row = 0; row < rows(); ++row) png_read_row(png_, pixels + row * width, nullptr);
        png_read_end(png_, nullptr);
        return true;
    }

    std::uint32_t columns() const { return png_get_image_width(png_, info_); }
    std::uint32_t rows() const { return png_get_image_height(png_, info_); }
    int bits() const { return png_get_bit_depth(png_, info_); }
    int colour() const { return png_get_color_type(png_, info_); }
    const char* why() const { return why_.data(); }

private:
    static PngReader& self(png_voidp pointer) { return *static_cast<PngReader*>(pointer); }
    [[noreturn]] static void fail(png_structp png, png_const_charp why)
    {
        std::strncpy(self(png_get_error_ptr(png)).why_.data(), why, most - 1);
        png_longjmp(png, 1);
    }
    static void warn(png_structp, png_const_charp) {}
    static void read(png_structp png, png_bytep out, std::size_t count)
    {
        PngReader& reader = self(png_get_io_ptr(png));
        if (count > reader.bytes_.size() - reader.at_) png_error(png, "the file is cut off");
        std::memcpy(out, reader.bytes_.data() + reader.at_, count);
        reader.at_ += count;
    }

    static constexpr std::size_t most = 200;
    std::string_view bytes_;
    std::size_t at_ = 0;
    std::array<char, most> why_{};
    png_structp png_ = nullptr;
    png_infop info_ = nullptr;
};

} // namespace

HeightRaster read_grey_png(const std::string& name, std::string_view bytes)
{
    if (!bytes.starts_with("\x89PNG\r\n\x1a\n")) refuse(name, "not a PNG file");
    PngReader png(bytes);
    const auto fail = [&] { refuse(name, fmt::format("cannot be read as a PNG: {}", png.why())); };
    if (!png.read_header()) fail();
    const int bits = png.bits();
    if (png.colour() != PNG_COLOR_TYPE_GRAY || (bits != 8 && bits != 16))
        refuse(name, fmt::format("a PNG of colour type {} and {} bits; heights are grey (type 0), of 8 or 16 bits",
                                 png.colour(), bits));
    HeightRaster raster;
    raster.columns = png.columns(), raster.rows = png.rows(), raster.whole = true;
    // Deflate compresses at most 1032 bytes into one; a small file must still not fill the memory.
    constexpr std::uint64_t most_of_small_files = 20'000'000, most_a_byte = 64;
    const std::uint64_t samples = std::uint64_t(raster.columns) * raster.rows;
    if (samples / 1032 > bytes.size())
        refuse(name, fmt::format("{} x {} heights are announced; {} bytes cannot hold them", raster.columns,
                                 raster.rows, bytes.size()));
    if (samples > std::max(most_of_small_files, most_a_byte * bytes.size()))
        refuse(name, fmt::format("{} heights in {} bytes; at most {}, or {} a byte, are allowed", samples, bytes.size(),
                                 most_of_small_files, most_a_byte));
    const std::size_t width = std::size_t(raster.columns) * static_cast<std::size_t>(bits / 8);
    std::vector<png_byte> pixels(width * raster.rows);
    if (!png.read_rows(pixels.data(), width)) fail();
    raster.heights.reserve(samples);
    for (std::size_t i = 0; i < samples; ++i)
        raster.heights.push_back(bits == 8 ? pixels[i] : pixels[2 * i] << 8 | pixels[2 * i + 1]);
    return raster;
}

} // namespace oncollide
