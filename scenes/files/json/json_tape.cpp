#include <oncollide/scenes/files/json/json_tape.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif
#include <nlohmann/json.hpp>

#include <oncollide/scenes/files/mesh/decimal.hpp>

namespace oncollide {

namespace {

using Kind = JsonValue::Kind;

/// True for a byte of a text that needs no treatment: not its end, an escape, or part of a multi-byte character, which
/// must be checked.
bool is_plain(char c)
{
    const auto byte = static_cast<unsigned char>(c);
    return byte >= 0x20 && byte < 0x80 && c != '"' && c != '\\';
}

/// The bytes that matter for skipping an array.
constexpr std::array<bool, 256> is_structure = [] {
    std::array<bool, 256> is{};
    for (const unsigned char c : {'"', ',', '[', ']', '{', '}'}) is[c] = true;
    return is;
}();

/// The first byte that separates elements, or begins or ends an array, an object or a text; `end` if there is none.
const char* find_structure(const char* at, const char* end)
{
#if defined(__SSE2__)
    const auto is = [](__m128i bytes, char c) { return _mm_cmpeq_epi8(bytes, _mm_set1_epi8(c)); };
    for (; end - at >= 16; at += 16) {
        const __m128i bytes = _mm_loadu_si128(reinterpret_cast<const __m128i*>(at));
        const __m128i folded = _mm_or_si128(bytes, _mm_set1_epi8(0x20)); // folds '[' to '{' and ']' to '}'
        const __m128i found =
            _mm_or_si128(_mm_or_si128(is(bytes, '"'), is(bytes, ',')), _mm_or_si128(is(folded, '{'), is(folded, '}')));
        if (const int mask = _mm_movemask_epi8(found)) return at + std::countr_zero(static_cast<unsigned>(mask));
    }
#endif
    while (at != end && !is_structure[static_cast<unsigned char>(*at)]) ++at;
    return at;
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
    const char* at = at_;
    while (at != end_ && is_json_blank(*at)) ++at;
    at_ = at;
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
    JsonValue& value = values_.emplace_back(); // valid until the next value is added
    value.parent = parent;
    value.source = begin;
    switch (*at_) {
    case '{':
    case '[':
        if (level >= most_json_levels) fail();
        value.kind = *at_ == '{' ? Kind::object : Kind::array;
        *at_ == '{' ? read_object(number, level) : read_array(number, level);
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
    std::unordered_set<std::string_view> keys; // used only for large objects
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
            if (each == key) break; // the key just read, which has no value yet
        }
}

void JsonTape::skip_array(JsonValue& array)
{
    array.source = at_;
    std::uint64_t commas = 0;
    const char* at = at_; // a local variable, which the compiler can keep in a register
    for (std::int64_t open = 0;; ++at) {
        at = find_structure(at, end_);
        if (at == end_) break;
        const char c = *at;
        if (c == '"') {
            for (++at; at != end_ && *at != '"'; ++at)
                if (*at == '\\' && at + 1 != end_) ++at;
            if (at == end_) break;
        } else if (c == '{' || c == '[') {
            ++open;
        } else if (c == ',') {
            commas += open == 1;
        } else if (--open == 0) {
            break;
        }
    }
    at_ = at;
    if (at == end_) fail();
    const bool empty = std::all_of(array.source + 1, at, is_json_blank);
    ++at_;
    array.length = static_cast<std::uint32_t>(at_ - array.source);
    array.size = empty ? 0 : commas + 1;
}

void JsonTape::read_text(JsonValue& value)
{
    value.kind = Kind::text;
    const char* const begin = ++at_;
    const char* at = begin;
    while (at != end_ && is_plain(*at)) ++at;
    at_ = at;
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
    std::uint64_t digits = 0;
    std::size_t count = 0;
    const auto read_some = [&](std::uint64_t& to) {
        const char* const first = at_;
        at_ = read_digits(at_, end_, to);
        if (at_ == first) fail();
        return static_cast<std::size_t>(at_ - first);
    };
    const bool minus = *at_ == '-';
    if (minus) ++at_;
    if (at_ != end_ && *at_ == '0')
        ++at_, count = 1;
    else
        count = read_some(digits);
    bool whole = true, scaled = false;
    std::size_t decimals = 0;
    if (at_ != end_ && *at_ == '.') {
        whole = false, ++at_;
        decimals = read_some(digits), count += decimals;
    }
    if (at_ != end_ && (*at_ == 'e' || *at_ == 'E')) {
        whole = false, scaled = true;
        ++at_;
        if (at_ != end_ && (*at_ == '+' || *at_ == '-')) ++at_;
        std::uint64_t exponent = 0;
        read_some(exponent);
    }
    if (whole) {
        value.kind = minus ? Kind::negative : Kind::natural;
        const std::errc error =
            minus ? std::from_chars(begin, at_, value.negative).ec : std::from_chars(begin, at_, value.natural).ec;
        if (error == std::errc()) return;
    }
    value.kind = Kind::real;
    if (!scaled && exact_quotient(digits, count, decimals, value.real)) {
        if (minus) value.real = -value.real;
        return;
    }
    if (std::from_chars(begin, at_, value.real).ec == std::errc()) return;
    value.real = std::strtod(std::string(begin, at_).c_str(), nullptr); // out of range: infinite, or nearly 0
    if (!std::isfinite(value.real)) fail();
}

} // namespace oncollide
