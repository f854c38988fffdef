// NumPy's arrays. Source: "The .npy format", numpy.lib.format, versions 1.0 to 3.0.
#include <charconv>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/files/terrain/height_raster.hpp>

namespace oncollide {

namespace {

/// What stands after 'key': in the header, a literal of a Python dictionary.
std::string_view value_of(const std::string& name, std::string_view header, std::string_view key)
{
    for (const char quote : {'\'', '"'}) {
        const std::string quoted = quote + std::string(key) + quote;
        const std::size_t at = header.find(quoted);
        if (at == header.npos) continue;
        const std::size_t value = header.find_first_not_of(" :", at + quoted.size());
        if (value != header.npos) return header.substr(value);
    }
    refuse(name, fmt::format("the header has no '{}'", key));
}

} // namespace

HeightRaster read_npy(const std::string& name, std::string_view bytes)
{
    constexpr std::string_view magic = "\x93NUMPY";
    if (!bytes.starts_with(magic)) refuse(name, "not a NumPy array: the file must begin with '\\x93NUMPY'");
    const auto byte = [&](std::size_t i) {
        if (i >= bytes.size()) refuse(name, "the file ends within the header");
        return std::size_t{static_cast<unsigned char>(bytes[i])};
    };
    const std::size_t version = byte(6);
    if (version < 1 || version > 3) refuse(name, fmt::format("version {} of the format; 1 to 3 are known", version));
    std::size_t begin = version == 1 ? 10 : 12, length = 0;
    for (std::size_t i = begin; i-- > 8;) length = length << 8 | byte(i);
    if (length > bytes.size() - begin) refuse(name, "the file ends within the header");
    const std::string_view header = bytes.substr(begin, length), data = bytes.substr(begin + length);

    const std::string_view descr = value_of(name, header, "descr"), shape = value_of(name, header, "shape");
    if (descr.empty() || (descr[0] != '\'' && descr[0] != '"')) refuse(name, "not an array of plain numbers");
    const SampleType type = sample_type(name, descr.substr(1, descr.find(descr[0], 1) - 1));
    const bool columns_first = value_of(name, header, "fortran_order").starts_with("True");

    std::uint32_t sides[2];
    const char *at = shape.data() + 1, *const end = shape.data() + shape.size();
    for (std::uint32_t& side : sides) {
        while (at < end && (*at == ' ' || *at == ',')) ++at;
        const auto [after, error] = std::from_chars(at, end, side);
        if (error != std::errc() || !shape.starts_with('('))
            refuse(name, fmt::format("the shape is {}; it must be two numbers: rows and columns",
                                     shape.substr(0, shape.find(')') + 1)));
        at = after;
    }
    if (const std::string_view rest(at, static_cast<std::size_t>(end - at));
        rest.find_first_not_of(" ,") != rest.find(')'))
        refuse(name, fmt::format("the shape is {}; it must be two numbers: rows and columns",
                                 shape.substr(0, shape.find(')') + 1)));

    HeightRaster raster;
    raster.rows = sides[0], raster.columns = sides[1];
    check_size(name, raster.columns, raster.rows, type.size, data.size());
    raster.heights = decoded(type, data);
    raster.whole = type.kind != 'f';
    if (columns_first) {
        std::vector<double> turned(raster.heights.size());
        for (std::size_t i = 0; i < turned.size(); ++i)
            turned[i] = raster.heights[i % raster.columns * raster.rows + i / raster.columns];
        raster.heights = std::move(turned);
    }
    return raster;
}

} // namespace oncollide
