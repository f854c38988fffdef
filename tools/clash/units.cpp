#include "clash/units.hpp"

#include <charconv>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/scenes/files/scene_file.hpp>

#include "clash/name_pattern.hpp"
#include "cli/arguments.hpp"

namespace oncollide::tools {
namespace {

constexpr Unit all_units[] = {{"mm", 1}, {"cm", 10}, {"m", 1000}, {"in", 25.4}};

const Unit* find(std::string_view name)
{
    for (const Unit& unit : all_units)
        if (unit.name == name) return &unit;
    return nullptr;
}

} // namespace

const Unit& unit_from(const std::string& option, std::string_view name)
{
    if (const Unit* unit = find(name)) return *unit;
    usage(fmt::format("{} {}: unknown unit; valid: mm, cm, m, in", option, name));
}

double length_from(const std::string& option, const std::string& text, const Unit& unit)
{
    double value = 0;
    const char* end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(text.data(), end, value);
    std::string_view suffix(rest, std::size_t(end - rest));
    suffix.remove_prefix(std::min(suffix.find_first_not_of(' '), suffix.size()));
    const Unit* given = suffix.empty() ? &unit : find(suffix);
    if (error != std::errc{} || !given || !(value >= 0) || !std::isfinite(value))
        usage(fmt::format("{} {}: expected a length of 0 or more, such as 2mm, 0.1in or a number in {}", option, text,
                          unit.name));
    return given == &unit ? value : value * (given->millimetres / unit.millimetres);
}

Units::Units(const std::vector<std::string>& texts) : reported_(&all_units[0])
{
    for (const std::string& text : texts) {
        const std::size_t at = text.rfind('=');
        if (at == text.npos)
            reported_ = &unit_from("--units", text);
        else if (at == 0)
            usage(fmt::format("--units {}: expected a unit, or PATTERN=UNIT such as 'frame*.stl=m'", text));
        else
            of_files_.push_back({text.substr(0, at), &unit_from("--units " + text + ":", text.substr(at + 1))});
    }
}

double Units::scale_of(const std::string& file) const
{
    const std::filesystem::path path(file);
    const std::string extension = lower_extension(path);
    const bool says_itself = extension == ".dae" || extension == ".3mf"; // read in metres
    const Unit* unit = is_assembly_file(path) ? &unit_from("", "m") : reported_;
    for (const OfFiles& some : of_files_) {
        if (!matches(some.pattern, file) && !matches(some.pattern, path.filename().string())) continue;
        if (says_itself)
            usage(fmt::format("--units {}={}: {} defines its own unit", some.pattern, some.unit->name, file));
        unit = some.unit;
    }
    return unit == reported_ ? 1 : unit->millimetres / reported_->millimetres;
}

} // namespace oncollide::tools
