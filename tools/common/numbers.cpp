#include "common/numbers.hpp"

#include <cctype>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>

namespace oncollide::tools {

void refuse_numbers(const std::string& option, const std::string& text, const std::string& why, const char* form)
{
    throw Error(ErrorKind::usage, fmt::format("{} \"{}\": {}; expected \"{}\"", option, text, why, form));
}

std::vector<double> parse_numbers(const std::string& option, const std::string& text, std::size_t count,
                                  const char* form)
{
    std::vector<double> numbers;
    const char *at = text.data(), *end = at + text.size();
    while (true) {
        while (at != end && (std::isspace(static_cast<unsigned char>(*at)) || *at == ',')) ++at;
        if (at == end) break;
        if (*at == '+') ++at; // from_chars takes no plus sign
        double value = 0;
        const auto [next, error] = std::from_chars(at, end, value);
        const bool ends = next == end || *next == ',' || std::isspace(static_cast<unsigned char>(*next));
        if (error == std::errc::result_out_of_range || (error == std::errc{} && !std::isfinite(value)))
            refuse_numbers(option, text, fmt::format("number {} is not finite", numbers.size() + 1), form);
        if (error != std::errc{} || !ends)
            refuse_numbers(option, text, fmt::format("number {} cannot be read", numbers.size() + 1), form);
        numbers.push_back(value);
        at = next;
    }
    if (numbers.size() != count) refuse_numbers(option, text, fmt::format("{} numbers", numbers.size()), form);
    return numbers;
}

} // namespace oncollide::tools
