#include "truth/setting_variants.hpp"

#include <algorithm>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>

namespace oncollide::tools {

void SettingVariant::change(std::string_view names)
{
    constexpr std::string_view comma = ", ";
    while (!names.empty()) {
        const std::string_view one = names.substr(0, names.find(comma));
        const auto known = std::ranges::find(setting_changes(), one, &SettingChange::name);
        if (known == setting_changes().end())
            throw Error(ErrorKind::internal, fmt::format("no change of settings is named '{}'", one));
        known->apply(settings);
        (name += name.empty() ? "" : comma) += one;
        names.remove_prefix(std::min(names.size(), one.size() + comma.size()));
    }
}

std::vector<SettingVariant> levels_and_volumes(std::span<const ExactLevel> levels, const Settings& base)
{
    std::vector<SettingVariant> all;
    for (const ExactLevel exact : levels)
        for (const char* volume : {"sphere", "obb"})
            all.emplace_back(SettingVariant{"", base}).change(fmt::format("{}, exact {}", volume, name_of(exact)));
    return all;
}

std::span<const SettingChange> setting_changes()
{
    const auto without = [](StageId stage) {
        return SettingChange{fmt::format("without {}", name_of(stage)), [stage](Settings& s) { s.skip.insert(stage); }};
    };
    static const std::vector<SettingChange> all{
        {"octree", [](Settings& s) { s.broad_phase = BroadPhaseKind::octree; }},
        {"brute", [](Settings& s) { s.broad_phase = BroadPhaseKind::brute_force; }},
        {"no coherence", [](Settings& s) { s.coherence = false; }},
        {"2 threads", [](Settings& s) { s.threads = 2; }},
        {"age 1", [](Settings& s) { s.age_limit = 1; }},
        without(StageId::bounds),
        without(StageId::delimitation),
        without(StageId::broad),
        without(StageId::refine),
        without(StageId::exact),
        {"exact off", [](Settings& s) { s.exact = ExactLevel::off; }},
        {"exact predicates", [](Settings& s) { s.exact = ExactLevel::predicates; }},
        {"exact fcl", [](Settings& s) { s.exact = ExactLevel::fcl; }},
        {"sphere", [](Settings& s) { s.bounding_volume = BoundingVolume::sphere; }},
        {"obb", [](Settings& s) { s.bounding_volume = BoundingVolume::obb; }},
        {"solid", [](Settings& s) { s.mode = Mode::solid, s.open_as_surface = true; }},
        {"kinds", [](Settings& s) { s.contact_kinds = true; }},
        {"touching ignored", [](Settings& s) { s.ignore_touching = true; }},
        {"clearance 0.05", [](Settings& s) { s.clearance = 0.05; }},
        {"error 0.01", [](Settings& s) { s.depth.reset(), s.max_error = 0.01; }},
        {"20 cells", [](Settings& s) { s.node_budget = 20; }},
        {"100 cells", [](Settings& s) { s.node_budget = 100; }},
        {"no memory", [](Settings& s) { s.memory_budget = 1; }}};
    return all;
}

std::span<const SettingChange> changes_of_method()
{
    return setting_changes().first(5);
}

std::span<const SettingChange> changes_without_stage()
{
    return setting_changes().subspan(5, 5);
}

} // namespace oncollide::tools
