#pragma once
#include <string>
#include <string_view>

namespace oncollide::tools {

/// A unit of length.
struct Unit {
    std::string_view name;
    double millimetres;
};

/// mm, cm, m or in; null for any other name.
const Unit* find_unit(std::string_view name);

/// The unit that find_unit() returns. Throws Error{usage} naming `option`.
const Unit& unit_from(const std::string& option, std::string_view name);

/// "2mm", "0.1 in" or a number of `unit`, in that unit; 0 or more. Throws Error{usage} naming `option`.
double length_from(const std::string& option, const std::string& text, const Unit& unit);

} // namespace oncollide::tools
