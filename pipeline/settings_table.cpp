#include <oncollide/pipeline/settings_table.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <type_traits>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <oncollide/base/error.hpp>
#include <oncollide/narrowphase/fcl/exact_fcl.hpp>
#include <oncollide/narrowphase/spheres/cell_key.hpp>

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
// The reverse operation.
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

void any(const Settings&) {}

void require(bool condition, std::string_view setting, auto value, std::string_view valid)
{
    if (!condition) throw Error(ErrorKind::usage, fmt::format("{} = {}: must be {}", setting, value, valid));
}

/// The texts of a row for help and pages.
struct Words {
    std::string_view options, group, value, help, by_default;
};

template <auto member>
constexpr SettingRow row(std::string_view member_name, std::string_view key, SettingForm form, bool affects_results,
                         const Words& words, void (*check)(const Settings&) = any)
{
    return {member_name,
            key,
            words.options,
            words.group,
            words.value,
            words.help,
            words.by_default,
            form,
            affects_results,
            check,
            [](const Settings& s) { return text(s.*member); },
            [](Settings& s, const nlohmann::json& from) { read(s.*member, from); }};
}

constexpr std::string_view accuracy = "Accuracy", computation = "Computation";
using enum SettingForm;

constexpr std::array table{
    row<&Settings::max_error>(
        "max_error", "max_error", length, true,
        {"--max-error", accuracy, "M",
         "accuracy in metres: bodies that are 'within' a bound are at most this far apart",
         "none: results are exact; with --exact off, 1 % of the diagonal of the AABB of the smaller body of each pair"},
        [](const Settings& s) {
            const double error = s.max_error.value_or(1);
            require(std::isfinite(error) && error > 0, "max-error", error, "a length in metres, above 0");
        }),
    row<&Settings::depth>(
        "depth", "depth", whole, true,
        {"--depth",
         accuracy,
         "D",
         "the paper's measure of accuracy, instead of an error in metres: depth of the sphere-trees, 1 to 16 levels",
         {}},
        [](const Settings& s) {
            const int depth = s.depth.value_or(1);
            require(depth >= 1 && depth <= deepest_level, "depth", depth, fmt::format("1 to {}", deepest_level));
        }),
    row<&Settings::clearance>(
        "clearance", "clearance", length, true,
        {"--clearance", accuracy, "M", "metres: bodies at most this far apart are not separate", "0"},
        [](const Settings& s) {
            require(std::isfinite(s.clearance) && s.clearance >= 0 && s.clearance <= 1e15, "clearance", s.clearance,
                    "a length in metres, 0 to 1e15");
        }),
    row<&Settings::exact>(
        "exact", "exact", name, true,
        {"--exact", accuracy, "auto|on|off|predicates|fcl",
         "decide exactly whether bodies collide, triangle by triangle: on (exact arithmetic; also called "
         "predicates), off (within an error), or fcl (a cross-check: only where FCL agrees)",
         "auto: on, unless an error, a depth, a clearance, spheres, a GPU for spheres or a memory budget is requested"},
        [](const Settings& s) {
            if (s.exact == ExactLevel::fcl && !fcl_available())
                throw Error(ErrorKind::usage,
                            "exact = fcl: this is a build without FCL (ONCOLLIDE_FCL=OFF); use predicates");
        }),
    row<&Settings::contact_kinds>("contact_kinds", "kinds", flag, true,
                                  {"--contact-kinds,--kinds",
                                   accuracy,
                                   {},
                                   "report whether colliding meshes only touch or cross; needs exact results",
                                   {}}),
    row<&Settings::ignore_touching>("ignore_touching", "ignore_touching", flag, true,
                                    {"--ignore-touching",
                                     accuracy,
                                     {},
                                     "report meshes that touch without crossing as separate; needs exact results",
                                     {}}),
    row<&Settings::mode>("mode", "mode", name, true,
                         {"--mode", accuracy, "surface|solid",
                          "surface, or solid: meshes must be closed and include their inside", "surface"}),
    row<&Settings::open_as_surface>(
        "open_as_surface", "open_as_surface", flag, true,
        {"--open-as-surface", accuracy, {}, "in solid mode, treat meshes that are not closed as surfaces", {}}),
    row<&Settings::threads>(
        "threads", "threads", whole, false,
        {"--threads", computation, "N", "number of threads; 0: all. Does not change the result", "1"},
        [](const Settings& s) {
            require(s.threads >= 0 && s.threads <= 1024, "threads", s.threads, "0 (all) to 1024");
        }),
    row<&Settings::backend>(
        "backend", "backend", name, true,
        {"--backend", computation, "cpu|gl|gl-compute|gl-query|auto",
         "cpu, or gl: a GPU decides pairs of meshes by OBB trees, with the same results; the CPU does where there is "
         "no GPU. The others build the sphere-trees of meshes (find grey cells): gl-compute (a GPU, the same results), "
         "gl-query (the paper's occlusion queries, which miss collisions), or auto: gl-compute on a real GPU, else cpu",
         "cpu"}),
    row<&Settings::gpu>("gpu", "gpu", whole, false,
                        {"--gpu", computation, "N", "number of the GPU in the list of 'oncollide doctor'", "the first"},
                        [](const Settings& s) {
                            require(s.gpu >= -1 && s.gpu < 64, "gpu", s.gpu,
                                    "0 to 63, or -1 for the first hardware GPU");
                        }),
    row<&Settings::viewport>("viewport", "viewport", whole, true,
                             {"--viewport", computation, "PX", "gl-query: pixels per side of a cell, 1 to 1024", "16"},
                             [](const Settings& s) {
                                 require(s.viewport >= 1 && s.viewport <= 1024, "viewport", s.viewport,
                                         "1 to 1024 pixels");
                             }),
    row<&Settings::bounding_volume>(
        "bounding_volume", "bounding_volume", name, true,
        {"--bounding-volume", computation, "auto|sphere|obb",
         "bounding volumes of a mesh's parts: obb (oriented boxes), or sphere, as in the paper, slower at equal error",
         "auto: obb if results are exact, and with the backends cpu and gl if the error is in metres; else sphere"}),
    row<&Settings::broad_phase>(
        "broad_phase", "broad", name, true,
        {"--broad", computation, "kd|octree|brute",
         "broad phase, which finds pairs of overlapping AABBs: a kd-tree, an octree, or brute force", "kd"}),
    row<&Settings::skip>("skip", "skip", names, true,
                         {"--skip",
                          computation,
                          "bounds|delimitation|broad|refine|exact",
                          "skip a stage (repeatable); results get wider, never wrong",
                          {}}),
    row<&Settings::age_limit>(
        "age_limit", "age", whole, false,
        {"--age", computation, "N", "drop parts of trees that no test used for this many frames", "60"},
        [](const Settings& s) {
            require(s.age_limit >= 1 && s.age_limit <= 1'000'000, "age", s.age_limit, "1 to 1000000 frames");
        }),
    row<&Settings::node_budget>(
        "node_budget", "node_budget", amount, true,
        {"--node-budget", computation, "N", "limit on the nodes (cells) of all trees together, e.g. 2M", "0: none"}),
    row<&Settings::memory_budget>("memory_budget", "memory_budget", amount, true,
                                  {"--memory-budget", computation, "BYTES",
                                   "limit on the bytes of all trees together, e.g. 64M. A quarter of it, 1 to 16 MiB, "
                                   "is for temporary buffers",
                                   "0: none"}),
    row<&Settings::resident_budget>(
        "resident_budget", "resident", amount, true,
        {"--resident", computation, "BYTES",
         "limit on the bytes of cooked meshes in memory, e.g. 64M. Changes a result only if a single pair needs more",
         "0: none"}),
    row<&Settings::look_ahead>(
        "look_ahead", "look_ahead", whole, false,
        {"--look-ahead", computation, "FRAMES",
         "frames for which a prefetch thread prepares the cooked meshes and tiles that bodies will come near, as "
         "predicted from their motion. Does not change the result",
         "0: off"},
        [](const Settings& s) {
            require(s.look_ahead >= 0 && s.look_ahead <= 10'000, "look-ahead", s.look_ahead, "0 (off) to 10000 frames");
        }),
    row<&Settings::coherence>("coherence", "coherence", flag, false,
                              {"--no-coherence",
                               computation,
                               {},
                               "test every pair from scratch, without using results of earlier frames; same result",
                               {}}),
};

} // namespace

std::span<const SettingRow> settings_table()
{
    return table;
}

const SettingRow* setting_of(std::string_view member)
{
    const auto* const found = std::ranges::find(table, member, &SettingRow::member);
    return found == table.end() ? nullptr : found;
}

void set_results_settings(Settings& settings, const nlohmann::json& from)
{
    for (const SettingRow& row : table)
        if (row.affects_results && from.contains(row.key)) row.set(settings, from.at(std::string(row.key)));
}

} // namespace oncollide
