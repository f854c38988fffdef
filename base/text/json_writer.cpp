#include <oncollide/base/text/json_writer.hpp>
#include <oncollide/base/utf8.hpp>

#include <algorithm>
#include <cmath>

namespace oncollide {

std::string json_string(std::string_view text)
{
    std::string result = "\"";
    while (!text.empty()) {
        const auto plain =
            std::ranges::find_if(text, [](unsigned char c) { return c < 0x20 || c == '"' || c == '\\' || c >= 0x80; });
        result.append(text.begin(), plain);
        text.remove_prefix(std::size_t(plain - text.begin()));
        if (text.empty()) break;
        const auto [code, bytes] = first_character(text);
        constexpr std::string_view escaped = "\b\f\n\r\t\"\\", letters = "bfnrt\"\\";
        if (const std::size_t at = escaped.find(text[0]); at != escaped.npos)
            result += {'\\', letters[at]};
        else if (code < 0x20)
            result += fmt::format("\\u{:04x}", code);
        else
            result += as_utf8(text.substr(0, bytes));
        text.remove_prefix(bytes);
    }
    return result + '"';
}

void JsonWriter::value(double x)
{
    separate();
    std::isfinite(x) ? out_->print("{}", x) : out_->write("null");
}

void JsonWriter::value(Fixed x)
{
    separate();
    std::isfinite(x.value) ? out_->print("{:.{}f}", x.value, x.digits) : out_->write("null");
}

void JsonWriter::value(Hex x)
{
    separate();
    out_->print("\"{:016x}\"", x.value);
}

void JsonWriter::separate()
{
    if (comma_) out_->write(indent_ < 0 ? ", " : ",");
    if (indent_ >= 0) out_->print("\n{:{}}", "", indent_);
    comma_ = true, indent_ = -1;
}

} // namespace oncollide
