#include <fmt/format.h>

#include "verify/trials/hard_trials.hpp"

namespace oncollide::tools {
namespace {

/// No exact level, predicates and FCL with both bounding volumes.
std::vector<Variant> plain(int depth)
{
    constexpr ExactLevel levels[] = {ExactLevel::off, ExactLevel::predicates, ExactLevel::fcl};
    std::vector<Variant> all;
    for (SettingVariant& v : levels_and_volumes(levels, {.depth = depth}))
        all.emplace_back(Variant{std::move(v)}).name.insert(0, fmt::format("depth {}, ", depth));
    return all;
}

/// Adds each plain variant with `change` applied.
template <class Change>
void add(std::vector<Variant>& all, int depth, const std::string& name, Change change)
{
    for (Variant& v : plain(depth)) {
        v.name += ", " + name;
        change(v);
        all.push_back(std::move(v));
    }
}

/// Every set of stages skipped, at two depths.
std::vector<Variant> sets_of_stages()
{
    std::vector<Variant> all;
    for (int depth : {2, 7})
        for (const Variant& v : plain(depth))
            for (unsigned skipped = 0; skipped < (exact_level(v.settings) == ExactLevel::off ? 16u : 32u); ++skipped) {
                Variant& changed = all.emplace_back(v);
                for (unsigned k = 0; k < 5; ++k)
                    if (skipped >> k & 1) {
                        const SettingChange without = without_stage(all_stages[k]);
                        changed.name += ", " + without.name;
                        without.apply(changed.settings);
                    }
            }
    return all;
}

std::vector<Variant> other_settings()
{
    std::vector<Variant> all;
    for (int depth : {1, 4, 10}) add(all, depth, "alone", [](Variant&) {});
    for (const SettingChange& change : changes_of_method())
        if (change.name != "2 threads") // two bodies give threads nothing to share; the crowd trial uses threads
            add(all, 6, change.name, [&](Variant& v) { change.apply(v.settings); });
    add(all, 6, "20 cells", [](Variant& v) { v.settings.node_budget = 20; });
    add(all, 6, "no memory", [](Variant& v) { v.settings.memory_budget = 1; });
    add(all, 6, "among others", [](Variant& v) { v.among_others = true; });
    add(all, 6, "among others, octree",
        [](Variant& v) { v.among_others = true, v.settings.broad_phase = BroadPhaseKind::octree; });
    return all;
}

std::vector<Variant> clearances()
{
    std::vector<Variant> all;
    for (double part : {1e-6, 1e-3, 0.1})
        add(all, 4, fmt::format("clearance {} of the size", part), [&](Variant& v) { v.of_size = part; });
    for (double part : {0.999, 1.0, 1.001})
        add(all, 4, fmt::format("clearance {} of the distance", part), [&](Variant& v) { v.of_distance = part; });
    const auto at_distance = [&](const std::string& name, auto change) {
        add(all, 4, "clearance the distance, " + name, [&](Variant& v) { v.of_distance = 1, change(v); });
    };
    for (const StageId stage : all_stages)
        at_distance(without_stage(stage).name, [&](Variant& v) { without_stage(stage).apply(v.settings); });
    std::erase_if(all, [](const Variant& v) { // FCL decides independently of earlier stages
        return exact_level(v.settings) == ExactLevel::fcl && !v.settings.skip.empty();
    });
    at_distance("octree", [](Variant& v) { v.settings.broad_phase = BroadPhaseKind::octree; });
    at_distance("brute force", [](Variant& v) { v.settings.broad_phase = BroadPhaseKind::brute_force; });
    at_distance("among others", [](Variant& v) { v.among_others = true; });
    at_distance("no memory", [](Variant& v) { v.settings.memory_budget = 1; });
    return all;
}

/// Meshes without an inside are treated as surfaces.
std::vector<Variant> solids()
{
    std::vector<Variant> all;
    for (int depth : {4, 7}) add(all, depth, "solid", [](Variant& v) { v.settings.mode = Mode::solid; });
    const auto solid = [&](const std::string& name, auto change) {
        add(all, 4, "solid, " + name,
            [&](Variant& v) { v.settings.mode = Mode::solid, v.closed_alone = true, change(v); });
    };
    for (const StageId stage : all_stages)
        solid(without_stage(stage).name, [&](Variant& v) { without_stage(stage).apply(v.settings); });
    solid("no memory", [](Variant& v) { v.settings.memory_budget = 1; });
    solid("among others", [](Variant& v) { v.among_others = true; });
    solid("clearance 0.1 of the size", [](Variant& v) { v.of_size = 0.1; });
    solid("clearance the distance", [](Variant& v) { v.of_distance = 1; });
    return all;
}

std::vector<Variant> kinds()
{
    std::vector<Variant> all;
    add(all, 4, "kinds", [](Variant& v) { v.settings.contact_kinds = true; });
    add(all, 4, "kinds, solid", [](Variant& v) { v.settings.contact_kinds = true, v.settings.mode = Mode::solid; });
    add(all, 4, "kinds, clearance 0.1 of the size",
        [](Variant& v) { v.settings.contact_kinds = true, v.of_size = 0.1; });
    add(all, 4, "touching ignored", [](Variant& v) { v.settings.ignore_touching = true; });
    add(all, 4, "touching ignored, no coherence",
        [](Variant& v) { v.settings.ignore_touching = true, v.settings.coherence = false; });
    std::erase_if(all, [](const Variant& v) { return exact_level(v.settings) != ExactLevel::predicates; });
    return all;
}

} // namespace

std::vector<Variant> all_variants()
{
    std::vector<Variant> all = sets_of_stages();
    for (const auto part : {other_settings, clearances, solids, kinds})
        for (Variant& v : part()) all.push_back(std::move(v));
    return all;
}

} // namespace oncollide::tools
