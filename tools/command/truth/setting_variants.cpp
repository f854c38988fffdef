#include "truth/setting_variants.hpp"

#include <fmt/format.h>

namespace oncollide::tools {

std::vector<SettingVariant> levels_and_volumes(std::span<const ExactLevel> levels, const Settings& base)
{
    std::vector<SettingVariant> all;
    for (ExactLevel exact : levels)
        for (BoundingVolume volume : {BoundingVolume::sphere, BoundingVolume::obb}) {
            SettingVariant& v =
                all.emplace_back(SettingVariant{fmt::format("{}, exact {}", name_of(volume), name_of(exact)), base});
            v.settings.exact = exact, v.settings.bounding_volume = volume;
        }
    return all;
}

std::vector<SettingChange> changes_of_method()
{
    return {{"octree", [](Settings& s) { s.broad_phase = BroadPhaseKind::octree; }},
            {"brute", [](Settings& s) { s.broad_phase = BroadPhaseKind::brute_force; }},
            {"no coherence", [](Settings& s) { s.coherence = false; }},
            {"2 threads", [](Settings& s) { s.threads = 2; }},
            {"age 1", [](Settings& s) { s.age_limit = 1; }}};
}

SettingChange without_stage(StageId stage)
{
    return {fmt::format("without {}", name_of(stage)), [stage](Settings& s) { s.skip.insert(stage); }};
}

} // namespace oncollide::tools
