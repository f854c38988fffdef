#include <oncollide/scenes/files/mesh/mesh_source.hpp>

#include <charconv>
#include <cmath>
#include <cstdlib>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/scenes/files/mesh/decimal.hpp>

namespace oncollide {

namespace {

/// `text` without blanks at its ends.
std::string_view trimmed(std::string_view text)
{
    while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
    return text;
}

} // namespace

void MeshSource::fail(const std::string& what, std::size_t line) const
{
    throw Error(ErrorKind::bad_data,
                line == 0 ? fmt::format("{}: {}", name, what) : fmt::format("{}: line {}: {}", name, line, what));
}

bool TextReader::next_line(bool continued)
{
    joined_.clear();
    while (!rest_.empty()) {
        const std::size_t end = rest_.find(line_end_);
        std::string_view text = rest_.substr(0, end);
        rest_ = end == rest_.npos ? std::string_view{} : rest_.substr(end + 1);
        ++line_;
        reached(text.data());
        text = trimmed(text.substr(0, text.find('#')));
        if (continued && text.ends_with('\\')) {
            joined_.append(text.substr(0, text.size() - 1)).push_back(' ');
            continue;
        }
        if (!joined_.empty()) text = trimmed(joined_.append(text));
        words_ = text;
        if (!text.empty()) return true;
        joined_.clear();
    }
    words_ = trimmed(joined_); // the file ends within a continued line
    return !words_.empty();
}

std::string_view TextReader::word()
{
    const char *begin = words_.data(), *const last = begin + words_.size();
    while (begin != last && is_blank(*begin)) ++begin;
    const char* end = begin;
    while (end != last && !is_blank(*end)) ++end;
    words_ = {end, static_cast<std::size_t>(last - end)};
    return {begin, static_cast<std::size_t>(end - begin)};
}

double TextReader::number(const char* what)
{
    const std::string_view text = word();
    double value = 0;
    if (text.empty()) fail(fmt::format("{} is missing", what));
    if (!parse(text, value) || !std::isfinite(value))
        fail(fmt::format("{} is {}; it must be a finite number", what, quoted(text)));
    return value;
}

std::int64_t TextReader::whole_number(const char* what)
{
    const std::string_view text = word();
    std::int64_t value = 0;
    if (text.empty()) fail(fmt::format("{} is missing", what));
    if (!parse(text, value)) fail(fmt::format("{} is {}; it must be a whole number", what, quoted(text)));
    return value;
}

Eigen::Vector3d TextReader::point()
{
    const double x = number("coordinate x"), y = number("coordinate y"), z = number("coordinate z");
    return {x, y, z};
}

std::string quoted(std::string_view word)
{
    return fmt::format("'{}{}'", printable(word.substr(0, 40)), word.size() > 40 ? "..." : "");
}

bool parse(std::string_view word, double& value)
{
    const char* const last = word.data() + word.size();
    if (read_decimal(word.data(), last, value) == last) return true;
    if (word.starts_with('+') && !word.starts_with("+-")) word.remove_prefix(1);
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (end != word.data() + word.size()) return false;
    if (error == std::errc::result_out_of_range) value = std::strtod(std::string(word).c_str(), nullptr);
    return error != std::errc::invalid_argument;
}

bool parse(std::string_view word, std::int64_t& value)
{
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    return error == std::errc{} && end == word.data() + word.size();
}

} // namespace oncollide
