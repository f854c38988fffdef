#include <oncollide/pipeline/settings.hpp>

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/text/near_word.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/pipeline/result_hash.hpp>
#include <oncollide/pipeline/settings_rules.hpp>
#include <oncollide/pipeline/settings_table.hpp>

namespace oncollide {

namespace {

constexpr std::array<std::string_view, 4> exact_names{"off", "predicates", "fcl", "auto"};
constexpr std::array<std::string_view, 2> mode_names{"surface", "solid"};
constexpr std::array<std::string_view, 5> backend_names{"auto", "cpu", "gl-compute", "gl-query", "gl"};
constexpr std::array<std::string_view, 3> broad_names{"kd", "octree", "brute"};
constexpr std::array<std::string_view, 3> bounding_volume_names{"auto", "sphere", "obb"};
constexpr std::array<std::string_view, stage_count> stage_names{"bounds", "delimitation", "broad", "refine", "exact"};

/// @param offered  the names that an error lists; empty: all
template <class Enum, std::size_t n>
Enum from_name(std::string_view what, const std::array<std::string_view, n>& names, std::string_view name,
               std::vector<std::string_view> offered = {})
{
    for (std::size_t i = 0; i < n; ++i)
        if (names[i] == name) return static_cast<Enum>(i);
    if (offered.empty()) offered.assign(names.begin(), names.end());
    throw Error(ErrorKind::usage, fmt::format("{}: no '{}'{}", what, name, valid_names(name, offered)));
}

} // namespace

std::string_view name_of(ExactLevel v)
{
    return exact_names[static_cast<std::size_t>(v)];
}
std::string_view name_of(Mode v)
{
    return mode_names[static_cast<std::size_t>(v)];
}
std::string_view name_of(BackendKind v)
{
    return backend_names[static_cast<std::size_t>(v)];
}
std::string_view name_of(BroadPhaseKind v)
{
    return broad_names[static_cast<std::size_t>(v)];
}
std::string_view name_of(BoundingVolume v)
{
    return bounding_volume_names[static_cast<std::size_t>(v)];
}
ExactLevel exact_from_name(std::string_view name)
{
    if (name == "on") return ExactLevel::predicates;
    return from_name<ExactLevel>("exact", exact_names, name, {"auto", "on", "off", "predicates", "fcl"});
}
Mode mode_from_name(std::string_view name)
{
    return from_name<Mode>("mode", mode_names, name);
}
BackendKind backend_from_name(std::string_view name)
{
    return from_name<BackendKind>("backend", backend_names, name);
}
BroadPhaseKind broad_phase_from_name(std::string_view name)
{
    return from_name<BroadPhaseKind>("broad", broad_names, name);
}
BoundingVolume bounding_volume_from_name(std::string_view name)
{
    return from_name<BoundingVolume>("bounding-volume", bounding_volume_names, name);
}

std::string_view name_of(StageId v)
{
    return stage_names[static_cast<std::size_t>(v)];
}
std::span<const std::string_view> all_stage_names()
{
    return stage_names;
}
StageId stage_from_name(std::string_view name)
{
    return from_name<StageId>("stage", stage_names, name);
}

StageSet stages_from_names(std::span<const std::string> names)
{
    StageSet stages;
    for (const std::string& name : names) stages.insert(stage_from_name(name));
    return stages;
}
std::vector<std::string> names_of(StageSet stages)
{
    std::vector<std::string> names;
    for (std::size_t k = 0; k < stage_count; ++k)
        if (const auto stage = static_cast<StageId>(k); stages.contains(stage)) names.emplace_back(name_of(stage));
    return names;
}

std::uint64_t hash_of(const Settings& s)
{
    const std::string text =
        fmt::format("{} {:a} {:a} {} {} {} {} {} {} {}", s.depth.value_or(0), s.max_error.value_or(0), s.clearance,
                    name_of(exact_level(s)), s.contact_kinds, s.ignore_touching, name_of(s.mode), s.open_as_surface,
                    wants_obbs(s), fmt::join(names_of(s.skip), ","));
    std::uint64_t hash = 0;
    for (const char c : text) mix(hash, std::uint8_t(c));
    return hash;
}

void check(const Settings& s)
{
    const auto refuse = [](const std::string& why) { throw Error(ErrorKind::usage, why); };
    for (const SettingRow& row : settings_table()) row.check(s);
    if (s.depth && s.max_error) refuse("depth and max-error: give one of them, they set the same dial");
    if (wants_kinds(s) && exact_level(s) != ExactLevel::predicates)
        refuse(fmt::format("{} needs exact = predicates, which distinguish touching from crossing; exact is {}",
                           s.ignore_touching ? "ignore-touching" : "kinds", name_of(exact_level(s))));
    if (s.open_as_surface && s.mode != Mode::solid)
        refuse("open-as-surface needs mode = solid: in surface mode all meshes are surfaces");
    if (s.ignore_touching && s.mode == Mode::solid)
        refuse("ignore-touching needs mode = surface: solid bodies whose surfaces only touch may still overlap");
    if (s.ignore_touching && s.clearance > 0)
        refuse("ignore-touching needs clearance = 0: bodies that touch are inside any clearance");
    if (s.look_ahead > 0 && s.memory_budget > 0)
        refuse("look-ahead excludes memory-budget, because results would depend on the progress of a thread; limit "
               "cooked meshes with resident instead");
}

int thread_count(const Settings& s)
{
    if (s.threads != 0) return s.threads;
    return std::max(1, (s.executor ? *s.executor : current_executor()).threads());
}

} // namespace oncollide
