#include <oncollide/base/printable.hpp>

#include <cstdint>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>

namespace oncollide {

namespace {

/// A UTF-8 character and its number of bytes. `none`, with 1 byte, stands for an invalid byte.
struct Character {
    static constexpr std::uint32_t none = 0xffffffffu;
    std::uint32_t code;
    std::size_t bytes;
};

Character first_of(std::string_view text)
{
    const auto lead = static_cast<unsigned char>(text[0]);
    if (lead < 0x80) return {lead, 1};
    const std::size_t bytes = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
    if (lead < 0xc2 || lead > 0xf4 || text.size() < bytes) return {Character::none, 1};
    std::uint32_t code = lead & (0xffu >> (bytes + 1));
    for (std::size_t i = 1; i < bytes; ++i) {
        const auto next = static_cast<unsigned char>(text[i]);
        if ((next & 0xc0) != 0x80) return {Character::none, 1};
        code = code << 6 | (next & 0x3f);
    }
    const bool too_long = (bytes == 3 && code < 0x800) || (bytes == 4 && code < 0x10000);
    const bool surrogate = code >= 0xd800 && code < 0xe000;
    if (too_long || surrogate || code > 0x10ffff) return {Character::none, 1};
    return {code, bytes};
}

bool acts(std::uint32_t code)
{
    return code < 0x20 || (code >= 0x7f && code < 0xa0) ||                             // C0, DEL, C1
           code == 0x61c || code == 0x200e || code == 0x200f ||                        // direction marks
           (code >= 0x202a && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069) || // embeddings, isolates
           code == 0x2028 || code == 0x2029;                                           // line, paragraph
}

std::string escape(std::string_view text, bool lines)
{
    std::string result;
    result.reserve(text.size());
    while (!text.empty()) {
        const auto [code, bytes] = first_of(text);
        if (code == Character::none)
            result += fmt::format("\\x{:02x}", static_cast<unsigned char>(text[0]));
        else if (!acts(code) || (lines && code == '\n'))
            result += text.substr(0, bytes);
        else
            result += code < 0x80 ? fmt::format("\\x{:02x}", code) : fmt::format("\\u{:04x}", code);
        text.remove_prefix(bytes);
    }
    return result;
}

} // namespace

std::string printable(std::string_view text)
{
    return escape(text, false);
}

std::string printable_lines(std::string_view text)
{
    return escape(text, true);
}

Error::Error(ErrorKind kind, const std::string& message) : std::runtime_error(printable(message)), kind_(kind) {}

} // namespace oncollide
