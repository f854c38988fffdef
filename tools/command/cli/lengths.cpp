#include "cli/lengths.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include "cli/arguments.hpp"

namespace oncollide::tools {
namespace {

constexpr Unit all_units[] = {{"mm", 1}, {"cm", 10}, {"m", 1000}, {"in", 25.4}};

} // namespace

const Unit* find_unit(std::string_view name)
{
    for (const Unit& unit : all_units)
        if (unit.name == name) return &unit;
    return nullptr;
}

const Unit& unit_from(const std::string& option, std::string_view name)
{
    if (const Unit* unit = find_unit(name)) return *unit;
    usage(fmt::format("{} {}: unknown unit; valid: mm, cm, m, in", option, name));
}

double length_from(const std::string& option, const std::string& text, const Unit& unit)
{
    double value = 0;
    const char* end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(text.data(), end, value);
    std::string_view suffix(rest, std::size_t(end - rest));
    suffix.remove_prefix(std::min(suffix.find_first_not_of(' '), suffix.size()));
    const Unit* given = suffix.empty() ? &unit : find_unit(suffix);
    if (error != std::errc{} || !given || !(value >= 0) || !std::isfinite(value))
        usage(fmt::format("{} {}: expected a length of 0 or more, such as 2mm, 0.1in or a number in {}", option, text,
                          unit.name));
    // 9mm is 0.009, not 0.009000000000000001.
    return given == &unit ? value : value * given->millimetres / unit.millimetres;
}

} // namespace oncollide::tools
