#include "view/page_file.hpp"

#include <fmt/format.h>

namespace oncollide::tools {

void PageFile::until(std::string_view mark)
{
    const std::size_t at = rest_.find(mark);
    file_.write(rest_.substr(0, at));
    rest_.remove_prefix(at + mark.size());
}

void PageFile::add_json(std::string_view id, const nlohmann::json& value)
{
    file_.print("<script type=\"application/json\" id=\"{}\">{}</script>\n", id, script_json(value));
}

void PageFile::add_block(std::string_view id, std::string_view encoded)
{
    file_.print("<script type=\"text/plain\" id=\"{}\">", id);
    file_.write(encoded);
    file_.print("</script>\n");
}

std::string script_json(const nlohmann::json& value)
{
    std::string text;
    for (const char c : value.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace))
        c == '<' ? text += "\\u003c" : text += c;
    return text;
}

std::string megabytes(std::size_t bytes)
{
    return bytes < 100'000'000 ? fmt::format("{:.1f} MB", 1e-6 * double(bytes))
                               : fmt::format("{:.0f} MB", 1e-6 * double(bytes));
}

} // namespace oncollide::tools
