#include <oncollide/base/text/plain_number.hpp>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace oncollide {

std::string plain_number(double value, int digits)
{
    const double size = std::abs(value);
    if (size == 0) return "0";
    if (!(size >= 1e-4 && size < 1e15)) return fmt::format("{:.{}g}", value, digits); // writes infinity and NaN, too
    const int before = static_cast<int>(std::floor(std::log10(size))) + 1; // digits before the point; 0 or less below 1
    std::string text = fmt::format("{:.{}f}", value, std::max(0, digits - before));
    if (text.find('.') == text.npos) return text;
    text.erase(text.find_last_not_of('0') + 1);
    if (text.ends_with('.')) text.pop_back();
    return text;
}

std::string plain_measure(double value, int digits)
{
    std::string text = plain_number(value, digits);
    const std::size_t begin = value < 0, point = std::min(text.find_first_not_of("0123456789", begin), text.size());
    if (point - begin < 5) return text;
    for (std::size_t at = point; at > begin + 3;) text.insert(at -= 3, 1, ',');
    return text;
}

} // namespace oncollide
