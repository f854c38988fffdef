// All settings that can be written down, in one table: from it come the settings' part of results and its reader.
#pragma once
#include <span>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include <oncollide/pipeline/settings.hpp>

namespace oncollide {

/// One member of Settings. `executor` and `stop` have no row: they are objects of the running program.
struct SettingRow {
    std::string_view member;             ///< in C++ and Python
    std::string_view key;                ///< in JSON and, with hyphens, on the command line
    bool affects_results;                ///< false: only speed and memory
    std::string (*get)(const Settings&); ///< JSON text
    void (*set)(Settings&, const nlohmann::json&);
};
std::span<const SettingRow> settings_table();

/// Sets the members whose row affects results. Members without a key, as in files of older versions, keep their value.
/// Throws nlohmann::json::exception for a value of another type, Error{usage} for an unknown name.
void set_results_settings(Settings& settings, const nlohmann::json& from);

} // namespace oncollide
