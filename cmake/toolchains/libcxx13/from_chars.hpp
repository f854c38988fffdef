#pragma once
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <string>
#include <system_error>

namespace std {

enum class chars_format { scientific = 1, fixed = 2, hex = 4, general = 3 };

/// As in C++17, in general format: neither blanks nor a plus sign before the number. musl's strtod rounds correctly,
/// and Emscripten's decimal sign is always a point.
template <class Number>
requires is_floating_point_v<Number> from_chars_result from_chars(const char* first, const char* last, Number& value)
{
    const char* at = first;
    const bool minus = at < last && *at == '-';
    at += minus;
    const auto digits = [&] {
        const char* const begin = at;
        while (at < last && *at >= '0' && *at <= '9') ++at;
        return at - begin;
    };
    const auto word = [&](const char* name) {
        const char* p = at;
        for (; *name; ++p, ++name)
            if (p >= last || (*p | 32) != *name) return false;
        at = p;
        return true;
    };
    if (word("infinity") || word("inf") || word("nan")) {
        const bool nan = (at[-1] | 32) == 'n';
        const Number found = nan ? numeric_limits<Number>::quiet_NaN() : numeric_limits<Number>::infinity();
        value = minus ? -found : found;
        return {at, errc()};
    }
    auto count = digits();
    if (at < last && *at == '.') {
        ++at;
        const auto behind = digits();
        if (count + behind == 0) return {first, errc::invalid_argument};
        count += behind;
    }
    if (count == 0) return {first, errc::invalid_argument};
    if (at < last && (*at | 32) == 'e') {
        const char* const before = at++;
        if (at < last && (*at == '-' || *at == '+')) ++at;
        if (digits() == 0) at = before;
    }
    const string text(first, at);
    errno = 0;
    Number found;
    if constexpr (is_same_v<Number, float>)
        found = strtof(text.c_str(), nullptr);
    else
        found = strtod(text.c_str(), nullptr);
    if (errno == ERANGE && (std::isinf(found) || found == 0)) return {at, errc::result_out_of_range};
    value = found;
    return {at, errc()};
}

} // namespace std
