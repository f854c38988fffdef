// All settings that can be written down, in one table. Checks, the settings in JSON and their reader, the options of
// the command, the keywords of Python and the table in docs/choosing.md come from it.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include <oncollide/pipeline/settings.hpp>

namespace oncollide {

/// The type of a setting's value.
enum class SettingForm : std::uint8_t {
    flag,   ///< true or false
    whole,  ///< an int
    amount, ///< a size_t; the command accepts the suffixes K, M and G
    length, ///< a double, metres; the command accepts units, such as 1mm
    name,   ///< one of a list of names
    names,  ///< any of a list of names
};

/// One member of Settings. `executor` and `stop` have no row: they are objects of the running program.
struct SettingRow {
    std::string_view member;     ///< in C++ and Python
    std::string_view key;        ///< in JSON
    std::string_view options;    ///< on the command line, older spellings last
    std::string_view group;      ///< heading of the option in --help
    std::string_view value;      ///< value of the option in --help; empty for a flag
    std::string_view help;       ///< without a full stop
    std::string_view by_default; ///< the default, in words; empty for a flag, and if there is no value by default
    SettingForm form;
    bool affects_results; ///< false: only speed and memory
    /// Throws Error{usage} naming the setting, its value and the valid range.
    void (*check)(const Settings&);
    std::string (*get)(const Settings&); ///< JSON text
    /// Throws nlohmann::json::exception for a value of another type, Error{usage} for an unknown name.
    void (*set)(Settings&, const nlohmann::json&);

    /// The spelling of the option that is not an older one.
    std::string_view option() const { return options.substr(0, options.find(',')); }
    /// True if the option of a flag clears the flag.
    bool option_clears() const { return options.starts_with("--no-"); }
};
std::span<const SettingRow> settings_table();

/// The row of a member. Null: there is none.
const SettingRow* setting_of(std::string_view member);

/// Sets the members whose row affects results. Members without a key, as in files of older versions, keep their value.
/// Throws as SettingRow::set().
void set_results_settings(Settings& settings, const nlohmann::json& from);

} // namespace oncollide
