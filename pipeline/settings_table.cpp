#include <oncollide/pipeline/settings_table.hpp>

#include <array>
#include <optional>
#include <type_traits>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace oncollide {

namespace {

// JSON text of a value.
std::string text(bool value)
{
    return value ? "true" : "false";
}
std::string text(double value)
{
    return fmt::format("{}", value);
}
std::string text(StageSet stages)
{
    std::vector<std::string> quoted = names_of(stages);
    for (std::string& name : quoted) name = '"' + name + '"';
    return fmt::format("[{}]", fmt::join(quoted, ", "));
}
template <class Value>
requires std::is_enum_v<Value> std::string text(Value value)
{
    return fmt::format("\"{}\"", name_of(value));
}
template <class Value>
requires std::is_integral_v<Value> std::string text(Value value)
{
    return std::to_string(value);
}

template <class Value>
std::string text(const std::optional<Value>& value)
{
    return value ? text(*value) : "null";
}
// The reverse.
template <class Value>
void read(Value& value, const nlohmann::json& from)
{
    value = from.get<Value>();
}
template <class Value>
void read(std::optional<Value>& value, const nlohmann::json& from)
{
    value = from.is_null() ? std::nullopt : std::optional(from.get<Value>());
}
void read(StageSet& stages, const nlohmann::json& from)
{
    stages = stages_from_names(from.get<std::vector<std::string>>());
}
void read(ExactLevel& value, const nlohmann::json& from)
{
    value = exact_from_name(from.get<std::string>());
}
void read(Mode& value, const nlohmann::json& from)
{
    value = mode_from_name(from.get<std::string>());
}
void read(BackendKind& value, const nlohmann::json& from)
{
    value = backend_from_name(from.get<std::string>());
}
void read(BroadPhaseKind& value, const nlohmann::json& from)
{
    value = broad_phase_from_name(from.get<std::string>());
}
void read(BoundingVolume& value, const nlohmann::json& from)
{
    value = bounding_volume_from_name(from.get<std::string>());
}

template <auto member>
constexpr SettingRow row(std::string_view name, std::string_view key, bool affects_results)
{
    return {name, key, affects_results, [](const Settings& s) { return text(s.*member); },
            [](Settings& s, const nlohmann::json& from) { read(s.*member, from); }};
}

constexpr std::array table{
    row<&Settings::depth>("depth", "depth", true),
    row<&Settings::max_error>("max_error", "max_error", true),
    row<&Settings::clearance>("clearance", "clearance", true),
    row<&Settings::exact>("exact", "exact", true),
    row<&Settings::contact_kinds>("contact_kinds", "kinds", true),
    row<&Settings::ignore_touching>("ignore_touching", "ignore_touching", true),
    row<&Settings::mode>("mode", "mode", true),
    row<&Settings::open_as_surface>("open_as_surface", "open_as_surface", true),
    row<&Settings::backend>("backend", "backend", false),
    row<&Settings::broad_phase>("broad_phase", "broad", true),
    row<&Settings::bounding_volume>("bounding_volume", "bounding_volume", true),
    row<&Settings::gpu>("gpu", "gpu", false),
    row<&Settings::viewport>("viewport", "viewport", false),
    row<&Settings::threads>("threads", "threads", false),
    row<&Settings::skip>("skip", "skip", true),
    row<&Settings::age_limit>("age_limit", "age", false),
    row<&Settings::node_budget>("node_budget", "node_budget", false),
    row<&Settings::memory_budget>("memory_budget", "memory_budget", false),
    row<&Settings::coherence>("coherence", "coherence", false),
    row<&Settings::resident_budget>("resident_budget", "resident", false),
    row<&Settings::look_ahead>("look_ahead", "look_ahead", false),
};

} // namespace

std::span<const SettingRow> settings_table()
{
    return table;
}

void set_results_settings(Settings& settings, const nlohmann::json& from)
{
    for (const SettingRow& row : table)
        if (row.affects_results && from.contains(row.key)) row.set(settings, from.at(std::string(row.key)));
}

} // namespace oncollide
