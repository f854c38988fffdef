#include <oncollide/base/text/csv_writer.hpp>
#include <oncollide/base/utf8.hpp>

namespace oncollide {

namespace {

/// Spreadsheets treat a text that begins like this as a formula; "-5 %" is not one.
bool begins_formula(std::string_view text)
{
    if (text.empty() || std::string_view("=+-@\t\r").find(text[0]) == std::string_view::npos) return false;
    return text[0] != '-' || !text.ends_with(" %") ||
           text.substr(1, text.size() - 3).find_first_not_of("0123456789.") != std::string_view::npos;
}

} // namespace

std::string_view csv_text(std::string_view field)
{
    return field.starts_with('\'') && begins_formula(field.substr(1)) ? field.substr(1) : field;
}

std::string csv_field(std::string_view text, bool always)
{
    if (begins_formula(text)) return csv_field(fmt::format("'{}", text), always);
    const auto needs_care = [](unsigned char c) { return c >= 0x80 || c == ',' || c == '"' || c == '\r' || c == '\n'; };
    if (!always && std::ranges::none_of(text, needs_care)) return std::string(text);
    const std::string field = as_utf8(text);
    if (!always && field.find_first_of(",\"\r\n") == std::string::npos) return field;
    std::string result = "\"";
    for (const char c : field) result += c == '"' ? std::string_view("\"\"") : std::string_view(&c, 1);
    return result + '"';
}

} // namespace oncollide
