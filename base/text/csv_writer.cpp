#include <oncollide/base/text/csv_writer.hpp>
#include <oncollide/base/text/utf8.hpp>

namespace oncollide {

std::string csv_field(std::string_view text, bool always)
{
    const auto needs_care = [](unsigned char c) { return c >= 0x80 || c == ',' || c == '"' || c == '\r' || c == '\n'; };
    if (!always && std::ranges::none_of(text, needs_care)) return std::string(text);
    const std::string field = as_utf8(text);
    if (!always && field.find_first_of(",\"\r\n") == std::string::npos) return field;
    std::string result = "\"";
    for (const char c : field) result += c == '"' ? std::string_view("\"\"") : std::string_view(&c, 1);
    return result + '"';
}

} // namespace oncollide
