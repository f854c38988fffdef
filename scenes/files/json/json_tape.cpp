#include <oncollide/scenes/files/json/json_tape.hpp>

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include <nlohmann/json.hpp>

#include <oncollide/scenes/files/mesh/decimal.hpp>

namespace oncollide {

namespace {

using Kind = JsonValue::Kind;

/// Stands for itself in a text: neither the end of it, nor an escape, nor of several bytes, which must be checked.
bool is_plain(char c)
{
    const auto byte = static_cast<unsigned char>(c);
    return byte >= 0x20 && byte < 0x80 && c != '"' && c != '\\';
}

} // namespace

const char* JsonTape::read(std::string_view text, std::uint32_t level, std::string_view unread)
{
    values_.clear();
    decoded_.clear();
    unread_ = unread;
    at_ = text.data(), end_ = at_ + text.size();
    skip_blanks();
    read_value(0, level);
    return at_;
}

void JsonTape::skip_blanks()
{
    while (at_ != end_ && (*at_ == ' ' || *at_ == '\n' || *at_ == '\r' || *at_ == '\t')) ++at_;
}

bool JsonTape::take(char c)
{
    if (at_ == end_ || *at_ != c) return false;
    ++at_;
    skip_blanks();
    return true;
}

void JsonTape::read_value(std::uint32_t parent, std::uint32_t level)
{
    if (at_ == end_) fail();
    const auto number = static_cast<std::uint32_t>(values_.size());
    const char* const begin = at_;
    JsonValue value{};
    value.parent = parent;
    value.source = begin;
    const bool holds_others = *at_ == '{' || *at_ == '[';
    if (holds_others && level >= most_json_levels) fail();
    switch (*at_) {
    case '{':
        value.kind = Kind::object;
        values_.push_back(value);
        read_object(number, level);
        break;
    case '[':
        value.kind = Kind::array;
        values_.push_back(value);
        read_array(number, level);
        break;
    case '"':
        read_text(value);
        break;
    case 't':
        read_word(value, "true");
        break;
    case 'f':
        read_word(value, "false");
        break;
    case 'n':
        read_word(value, "null");
        break;
    default:
        read_number(value);
    }
    if (!holds_others) values_.push_back(value);
    values_[number].end = static_cast<std::uint32_t>(values_.size());
    values_[number].length = static_cast<std::uint32_t>(at_ - begin);
    skip_blanks();
}

void JsonTape::read_array(std::uint32_t array, std::uint32_t level)
{
    take('[');
    std::uint64_t size = 0;
    if (at_ == end_ || *at_ != ']') {
        do {
            read_value(array, level + 1);
            ++size;
        } while (take(','));
    }
    if (at_ == end_ || *at_ != ']') fail();
    ++at_;
    values_[array].size = size;
}

void JsonTape::read_object(std::uint32_t object, std::uint32_t level)
{
    take('{');
    std::uint64_t size = 0;
    std::unordered_set<std::string_view> keys; // of a large object
    if (at_ == end_ || *at_ != '}') {
        do {
            if (at_ == end_ || *at_ != '"') fail();
            const auto key = static_cast<std::uint32_t>(values_.size());
            read_value(object, level + 1);
            values_[object].size = size;
            check_new(object, key, keys);
            ++size;
            if (!take(':')) fail();
            if (object == 0 && !unread_.empty() && values_[key].as_text() == unread_ && at_ != end_ && *at_ == '[') {
                JsonValue value{};
                value.kind = Kind::array;
                skip_array(value);
                value.end = key + 2;
                values_.push_back(value);
                skip_blanks();
            } else {
                read_value(object, level + 1);
            }
        } while (take(','));
    }
    if (at_ == end_ || *at_ != '}') fail();
    ++at_;
    values_[object].size = size;
}

void JsonTape::check_new(std::uint32_t object, std::uint32_t key, std::unordered_set<std::string_view>& keys)
{
    constexpr std::uint64_t few = 16;
    const std::string_view name = values_[key].as_text();
    if (values_[object].size > few) {
        if (!keys.insert(name).second) fail();
        return;
    }
    for (std::uint32_t other = object + 1; other < key; other = values_[other + 1].end)
        if (values_[other].as_text() == name) fail();
    if (values_[object].size == few)
        for (std::uint32_t each = object + 1; each <= key; each = values_[each + 1].end) {
            keys.insert(values_[each].as_text());
            if (each == key) break; // its value is still to come
        }
}

void JsonTape::skip_array(JsonValue& array)
{
    array.source = at_;
    std::uint64_t commas = 0;
    bool empty = true;
    for (std::int64_t open = 0;; ++at_) {
        if (at_ == end_) fail();
        const char c = *at_;
        if (c == '"') {
            for (++at_; at_ != end_ && *at_ != '"'; ++at_)
                if (*at_ == '\\' && at_ + 1 != end_) ++at_;
            if (at_ == end_) fail();
            empty = false;
        } else if (c == '{' || c == '[') {
            if (++open > 1) empty = false;
        } else if (c == '}' || c == ']') {
            if (--open == 0) break;
        } else if (c == ',') {
            commas += open == 1;
        } else if (c > ' ') {
            empty = false;
        }
    }
    ++at_;
    array.length = static_cast<std::uint32_t>(at_ - array.source);
    array.size = empty ? 0 : commas + 1;
}

void JsonTape::read_text(JsonValue& value)
{
    value.kind = Kind::text;
    const char* const begin = ++at_;
    while (at_ != end_ && is_plain(*at_)) ++at_;
    if (at_ == end_) fail();
    if (*at_ == '"') {
        value.text = {begin, static_cast<std::size_t>(at_ - begin)};
        ++at_;
        return;
    }
    while (at_ != end_ && *at_ != '"') at_ += *at_ == '\\' && at_ + 1 != end_ ? 2 : 1;
    if (at_ == end_) fail();
    ++at_;
    try {
        decoded_.push_back(nlohmann::json::parse(begin - 1, at_).get<std::string>());
    } catch (const nlohmann::json::exception&) {
        fail();
    }
    value.text = {decoded_.back().data(), decoded_.back().size()};
}

void JsonTape::read_word(JsonValue& value, std::string_view word)
{
    if (!std::string_view(at_, static_cast<std::size_t>(end_ - at_)).starts_with(word)) fail();
    at_ += word.size();
    value.kind = word == "null" ? Kind::null : Kind::boolean;
    value.truth = word == "true";
}

void JsonTape::read_number(JsonValue& value)
{
    const char* const begin = at_;
    const auto digits = [&] {
        if (at_ == end_ || !is_digit(*at_)) fail();
        while (at_ != end_ && is_digit(*at_)) ++at_;
    };
    const bool minus = *at_ == '-';
    if (minus) ++at_;
    if (at_ != end_ && *at_ == '0')
        ++at_;
    else
        digits();
    bool whole = true;
    if (at_ != end_ && *at_ == '.') whole = false, ++at_, digits();
    if (at_ != end_ && (*at_ == 'e' || *at_ == 'E')) {
        whole = false;
        ++at_;
        if (at_ != end_ && (*at_ == '+' || *at_ == '-')) ++at_;
        digits();
    }
    if (whole) {
        value.kind = minus ? Kind::negative : Kind::natural;
        const std::errc error =
            minus ? std::from_chars(begin, at_, value.negative).ec : std::from_chars(begin, at_, value.natural).ec;
        if (error == std::errc()) return;
    }
    value.kind = Kind::real;
    if (std::from_chars(begin, at_, value.real).ec == std::errc()) return;
    value.real = std::strtod(std::string(begin, at_).c_str(), nullptr); // too large, or so small that it is all but 0
    if (!std::isfinite(value.real)) fail();
}

} // namespace oncollide
