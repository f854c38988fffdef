// NumPy arrays. Source: "The .npy format", numpy.lib.format, versions 1.0 to 3.0.
#include <charconv>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/files/common/npy.hpp>

namespace oncollide {

namespace {

/// The text after 'key': in the header, a literal of a Python dictionary.
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

NpyHeader read_npy_header(const std::string& name, std::string_view bytes)
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
    const std::string_view text = bytes.substr(begin, length);
    const std::string_view descr = value_of(name, text, "descr"), shape = value_of(name, text, "shape");
    if (descr.empty() || (descr[0] != '\'' && descr[0] != '"')) refuse(name, "not an array of plain numbers");
    NpyHeader header{.type = sample_type(name, descr.substr(1, descr.find(descr[0], 1) - 1)),
                     .columns_first = value_of(name, text, "fortran_order").starts_with("True"),
                     .shape = {},
                     .shape_text = std::string(shape.substr(0, shape.find(')') + 1)),
                     .bytes = begin + length};
    if (!shape.starts_with('(') || shape.find(')') == shape.npos) return header;
    std::vector<std::uint64_t> sides;
    for (const char *at = header.shape_text.data() + 1, *const end = at + header.shape_text.size() - 2;;) {
        while (at < end && (*at == ' ' || *at == ',')) ++at;
        if (at == end) break;
        std::uint64_t side = 0;
        const auto [after, error] = std::from_chars(at, end, side);
        if (error != std::errc()) return header;
        sides.push_back(side), at = after;
    }
    header.shape = std::move(sides);
    return header;
}

std::string npy_header(std::string_view type, std::span<const std::uint64_t> shape)
{
    std::string text =
        fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}", type, fmt::join(shape, ", "));
    text.append(63 - (10 + text.size()) % 64, ' ').push_back('\n');
    const char length[] = {static_cast<char>(text.size() & 0xff), static_cast<char>(text.size() >> 8)};
    return std::string("\x93NUMPY\x01\x00", 8) + std::string(length, 2) + text;
}

} // namespace oncollide
