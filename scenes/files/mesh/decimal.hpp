#pragma once
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

namespace oncollide {

// Fast parsing of the most common forms of numbers. Private to scenes.

inline bool is_digit(char c)
{
    return static_cast<unsigned char>(c - '0') < 10;
}

/// Reads digits from `at` and appends them to `value`, which wraps if there are too many; returns the first other byte.
/// Reads eight bytes at a time without branches on the number of digits. Source: Lemire, "Number parsing at a gigabyte
/// per second", 2021, section 7 (parsing digits).
[[gnu::always_inline]] inline const char* read_digits(const char* at, const char* end, std::uint64_t& value)
{
    static_assert(std::endian::native == std::endian::little);
    constexpr std::array<std::uint64_t, 9> powers = {1,       10,        100,        1'000,      10'000,
                                                     100'000, 1'000'000, 10'000'000, 100'000'000};
    while (end - at >= 8) {
        std::uint64_t bytes;
        std::memcpy(&bytes, at, 8);
        bytes ^= 0x3030303030303030u; // digits become their values; any other byte has bit 7 set, at the latest after
                                      // adding 0x76
        const int count = std::countr_zero(((bytes + 0x7676767676767676u) | bytes) & 0x8080808080808080u) / 8;
        if (count == 0) return at;
        bytes <<= 64 - 8 * count; // pads with leading zeros
        bytes = (bytes * 10 + (bytes >> 8)) & 0x00ff00ff00ff00ffu;
        bytes = (bytes * 100 + (bytes >> 16)) & 0x0000ffff0000ffffu;
        bytes = (bytes * 10'000 + (bytes >> 32)) & 0xffffffffu;
        value = value * powers[static_cast<std::size_t>(count)] + bytes;
        at += count;
        if (count < 8) return at;
    }
    while (at != end && is_digit(*at)) value = 10 * value + static_cast<std::uint64_t>(*at++ - '0');
    return at;
}

/// Computes the double nearest to digits / 10^decimals; returns false if that is not certain.
///
/// A whole number up to 2^53 and a power of ten up to 10^22 are doubles, so their quotient is rounded once. Source:
/// Clinger, "How to read floating point numbers accurately", 1990.
/// @param count  number of digits before and after the point: more than 19 may have wrapped
inline bool exact_quotient(std::uint64_t digits, std::size_t count, std::size_t decimals, double& value)
{
    constexpr std::array<double, 20> powers = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,
                                               1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19};
    if (count > 19 || digits > std::uint64_t{1} << 53) return false;
    value = static_cast<double>(digits) / powers[decimals];
    return true;
}

/// Reads [+-]digits[.digits] into the nearest double; null if the number has another form (an exponent) or too many
/// digits for certain rounding: then use std::from_chars.
inline const char* read_decimal(const char* at, const char* end, double& value)
{
    if (at == end) return nullptr;
    const bool minus = *at == '-';
    at += minus || *at == '+';
    std::uint64_t digits = 0;
    const char* const begin = at;
    at = read_digits(at, end, digits);
    std::size_t count = static_cast<std::size_t>(at - begin), decimals = 0;
    if (at != end && *at == '.') {
        const char* const point = at;
        at = read_digits(at + 1, end, digits);
        decimals = static_cast<std::size_t>(at - point - 1);
        count += decimals;
    }
    if (count == 0 || (at != end && (*at == 'e' || *at == 'E'))) return nullptr;
    if (!exact_quotient(digits, count, decimals, value)) return nullptr;
    if (minus) value = -value;
    return at;
}

} // namespace oncollide
