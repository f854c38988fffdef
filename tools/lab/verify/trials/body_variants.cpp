#include <fmt/format.h>

#include <oncollide/narrowphase/fcl/exact_fcl.hpp>

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

/// Changes a variant, but not its settings.
using Change = std::function<void(Variant&)>;

void among_others(Variant& v)
{
    v.among_others = true, v.name += ", among others";
}
void closed_alone(Variant& v)
{
    v.closed_alone = true;
}
Change of_size(double part)
{
    return [part](Variant& v) { v.of_size = part, v.name += fmt::format(", clearance {} of the size", part); };
}
Change of_distance(double part)
{
    return [part](Variant& v) { v.of_distance = part, v.name += fmt::format(", clearance {} of the distance", part); };
}

/// Adds each plain variant with changes of its settings, by their names, and with other changes.
void add(std::vector<Variant>& all, int depth, const std::string& names, const std::vector<Change>& changes = {})
{
    for (Variant& v : plain(depth)) {
        v.change(names);
        for (const Change& change : changes) change(v);
        all.push_back(std::move(v));
    }
}

/// Every set of stages skipped, at two depths.
void add_sets_of_stages(std::vector<Variant>& all)
{
    for (const int depth : {2, 7})
        for (const Variant& v : plain(depth))
            for (unsigned skipped = 0; skipped < (exact_level(v.settings) == ExactLevel::off ? 16u : 32u); ++skipped) {
                Variant& changed = all.emplace_back(v);
                for (unsigned k = 0; k < 5; ++k)
                    if (skipped >> k & 1) changed.change(changes_without_stage()[k].name);
            }
}

void add_other_settings(std::vector<Variant>& all)
{
    for (const int depth : {1, 4, 10}) add(all, depth, "");
    // Two bodies give threads nothing to share; the crowd trial uses threads.
    for (const char* change : {"octree", "brute", "no coherence", "age 1", "20 cells", "no memory"})
        add(all, 6, change);
    for (const char* change : {"", "octree"}) add(all, 6, change, {among_others});
}

void add_clearances(std::vector<Variant>& all)
{
    for (const double part : {1e-6, 1e-3, 0.1}) add(all, 4, "", {of_size(part)});
    for (const double part : {0.999, 1.0, 1.001}) add(all, 4, "", {of_distance(part)});
    for (const SettingChange& change : changes_without_stage()) add(all, 4, change.name, {of_distance(1)});
    std::erase_if(all, [](const Variant& v) { // FCL decides independently of earlier stages
        return v.of_distance == 1 && exact_level(v.settings) == ExactLevel::fcl && !v.settings.skip.empty();
    });
    for (const char* change : {"octree", "brute", "no memory"}) add(all, 4, change, {of_distance(1)});
    add(all, 4, "", {of_distance(1), among_others});
}

/// Meshes without an inside are treated as surfaces.
void add_solids(std::vector<Variant>& all)
{
    for (const int depth : {4, 7}) add(all, depth, "solid");
    for (const SettingChange& change : changes_without_stage()) add(all, 4, "solid, " + change.name, {closed_alone});
    add(all, 4, "solid, no memory", {closed_alone});
    for (const Change& change : {Change(among_others), of_size(0.1), of_distance(1)})
        add(all, 4, "solid", {closed_alone, change});
}

void add_kinds(std::vector<Variant>& all)
{
    std::vector<Variant> kinds;
    for (const char* changes : {"kinds", "kinds, solid", "touching ignored", "touching ignored, no coherence"})
        add(kinds, 4, changes);
    add(kinds, 4, "kinds", {of_size(0.1)});
    for (Variant& v : kinds)
        if (exact_level(v.settings) == ExactLevel::predicates) all.push_back(std::move(v));
}

} // namespace

std::vector<Variant> all_variants()
{
    std::vector<Variant> all;
    add_sets_of_stages(all), add_other_settings(all), add_clearances(all), add_solids(all), add_kinds(all);
    if (!fcl_available())
        std::erase_if(all, [](const Variant& v) { return exact_level(v.settings) == ExactLevel::fcl; });
    return all;
}

} // namespace oncollide::tools
