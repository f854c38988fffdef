#include <oncollide/base/text/listed.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/base/utf8.hpp>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>

namespace oncollide {

namespace {

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
        const auto [code, bytes] = first_character(text);
        if (code == Utf8Character::none)
            for (const char c : text.substr(0, bytes))
                result += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
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

Error::Error(ErrorKind kind, const std::string& message)
    : std::runtime_error(shortened(printable(message), most_of_a_message)), kind_(kind)
{
}

} // namespace oncollide
