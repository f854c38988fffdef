#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace oncollide {

struct Utf8Character {
    static constexpr std::uint32_t none = 0xffffffffu;
    std::uint32_t code; ///< none: not UTF-8
    std::size_t bytes;  ///< at least 1; for invalid text, the bytes that one U+FFFD replaces, as Unicode recommends
};

/// The first character of `text`, which is not empty.
Utf8Character first_character(std::string_view text);

/// `text` with U+FFFD in place of bytes that are not UTF-8, which file names may hold.
std::string as_utf8(std::string_view text);

} // namespace oncollide
