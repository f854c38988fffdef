#include <oncollide/base/utf8.hpp>

namespace oncollide {

Utf8Character first_character(std::string_view text)
{
    const auto lead = static_cast<unsigned char>(text[0]);
    if (lead < 0x80) return {lead, 1};
    if (lead < 0xc2 || lead > 0xf4) return {Utf8Character::none, 1};
    const std::size_t bytes = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
    // The second byte excludes longer forms than necessary, surrogates, and codes above 0x10ffff.
    unsigned least = lead == 0xe0 ? 0xa0 : lead == 0xf0 ? 0x90 : 0x80;
    unsigned most = lead == 0xed ? 0x9f : lead == 0xf4 ? 0x8f : 0xbf;
    std::uint32_t code = lead & (0xffu >> (bytes + 1));
    for (std::size_t i = 1; i < bytes; ++i, least = 0x80, most = 0xbf) {
        const unsigned next = i < text.size() ? static_cast<unsigned char>(text[i]) : 0;
        if (next < least || next > most) return {Utf8Character::none, i};
        code = code << 6 | (next & 0x3f);
    }
    return {code, bytes};
}

std::string as_utf8(std::string_view text)
{
    std::string result;
    result.reserve(text.size());
    while (!text.empty()) {
        const auto [code, bytes] = first_character(text);
        result += code == Utf8Character::none ? "\xef\xbf\xbd" : text.substr(0, bytes);
        text.remove_prefix(bytes);
    }
    return result;
}

} // namespace oncollide
