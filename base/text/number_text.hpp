#pragma once
#include <cstdint>
#include <string>

#include <fmt/format.h>

namespace oncollide {

// Numbers for JsonWriter and CsvWriter that are not written as the shortest text that reads back as the same value.
struct Fixed {
    double value;
    int digits; ///< number of digits after the point
};
struct Digits {
    double value;
    int digits; ///< number of significant digits
};
struct Hex {
    std::uint64_t value; ///< written with 16 digits; in JSON as a string
};

/// Digits in groups of three: 1,234,567.
inline std::string grouped(std::uint64_t value)
{
    return fmt::format("{}", fmt::group_digits(value));
}

/// sum / count: a whole number where it is whole or at least 1,000, otherwise one decimal; "-" when count is 0.
inline std::string mean_text(std::uint64_t sum, std::uint64_t count)
{
    if (count == 0) return "-";
    if (sum % count == 0 || sum / count >= 1000) return grouped((sum + count / 2) / count);
    return fmt::format("{:.1f}", double(sum) / double(count));
}

} // namespace oncollide
