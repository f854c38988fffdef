#include <charconv>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/files/common/sample_type.hpp>
#include <oncollide/scenes/files/terrain/height_raster.hpp>

namespace oncollide {

HeightRaster read_pgm(const std::string& name, std::string_view bytes)
{
    if (!bytes.starts_with("P5")) refuse(name, "not a binary PGM: the file must begin with 'P5'");
    std::size_t at = 2;
    const auto is_space = [](char c) { return c == ' ' || (c >= '\t' && c <= '\r'); };
    const auto number = [&](const char* what) {
        while (at < bytes.size() && (is_space(bytes[at]) || bytes[at] == '#'))
            at = bytes[at] == '#' ? std::min(bytes.find('\n', at), bytes.size()) : at + 1;
        std::uint32_t value = 0;
        const auto [end, error] = std::from_chars(bytes.data() + at, bytes.data() + bytes.size(), value);
        if (error != std::errc()) refuse(name, fmt::format("the header gives no {}", what));
        at = static_cast<std::size_t>(end - bytes.data());
        return value;
    };
    HeightRaster raster;
    raster.columns = number("width"), raster.rows = number("height");
    const std::uint32_t largest = number("greatest value");
    if (largest < 1 || largest > 65535)
        refuse(name, fmt::format("the greatest value is {}; 1 to 65535 are possible", largest));
    if (at == bytes.size() || !is_space(bytes[at])) refuse(name, "the file ends within the header");
    const std::string_view samples = bytes.substr(at + 1);
    const SampleType type{'u', largest > 255 ? std::size_t{2} : 1, true};
    check_size(name, raster.columns, raster.rows, type.size, samples.size());
    raster.heights = decoded(type, samples);
    raster.whole = true;
    return raster;
}

} // namespace oncollide
