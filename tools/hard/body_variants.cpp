#include <fmt/format.h>

#include "hard/body_trial.hpp"

namespace oncollide::tools {
namespace {

Variant variant(int depth, ExactLevel exact, BoundingVolume volume)
{
    Variant v;
    v.settings.depth = depth, v.settings.exact = exact, v.settings.bounding_volume = volume;
    v.name = fmt::format("depth {}, {}, exact {}", depth, name_of(volume), name_of(exact));
    return v;
}

/// Plain, predicates and FCL on both bounding volumes, each changed.
template <class Change>
void add(std::vector<Variant>& all, int depth, const std::string& name, Change change)
{
    for (ExactLevel exact : {ExactLevel::off, ExactLevel::predicates, ExactLevel::fcl})
        for (BoundingVolume volume : {BoundingVolume::sphere, BoundingVolume::obb}) {
            Variant& v = all.emplace_back(variant(depth, exact, volume));
            v.name += ", " + name;
            change(v);
        }
}

constexpr const char* stages[] = {"bounds", "delimitation", "broad", "ocst", "exact"};

/// Each set of stages left out, at two depths.
std::vector<Variant> sets_of_stages()
{
    std::vector<Variant> all;
    for (int depth : {2, 7})
        for (ExactLevel exact : {ExactLevel::off, ExactLevel::predicates, ExactLevel::fcl})
            for (BoundingVolume volume : {BoundingVolume::sphere, BoundingVolume::obb})
                for (unsigned skipped = 0; skipped < (exact == ExactLevel::off ? 16u : 32u); ++skipped) {
                    Variant& v = all.emplace_back(variant(depth, exact, volume));
                    for (unsigned k = 0; k < 5; ++k)
                        if (skipped >> k & 1)
                            v.settings.skip.emplace_back(stages[k]), v.name += fmt::format(", no {}", stages[k]);
                }
    return all;
}

std::vector<Variant> other_settings()
{
    std::vector<Variant> all;
    for (int depth : {1, 4, 10}) add(all, depth, "alone", [](Variant&) {});
    add(all, 6, "octree", [](Variant& v) { v.settings.broad_phase = BroadPhaseKind::octree; });
    add(all, 6, "brute force", [](Variant& v) { v.settings.broad_phase = BroadPhaseKind::brute_force; });
    add(all, 6, "no coherence", [](Variant& v) { v.settings.coherence = false; });
    add(all, 6, "cells dropped at once", [](Variant& v) { v.settings.age_limit = 1; });
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
    for (const char* stage : stages)
        at_distance(fmt::format("no {}", stage), [&](Variant& v) { v.settings.skip.emplace_back(stage); });
    std::erase_if(all, [](const Variant& v) { // FCL asks again whatever came before
        return v.settings.exact == ExactLevel::fcl && !v.settings.skip.empty();
    });
    at_distance("octree", [](Variant& v) { v.settings.broad_phase = BroadPhaseKind::octree; });
    at_distance("brute force", [](Variant& v) { v.settings.broad_phase = BroadPhaseKind::brute_force; });
    at_distance("among others", [](Variant& v) { v.among_others = true; });
    at_distance("no memory", [](Variant& v) { v.settings.memory_budget = 1; });
    return all;
}

/// Meshes without an inside are taken as the surfaces that they are.
std::vector<Variant> solids()
{
    std::vector<Variant> all;
    for (int depth : {4, 7}) add(all, depth, "solid", [](Variant& v) { v.settings.mode = Mode::solid; });
    const auto solid = [&](const std::string& name, auto change) {
        add(all, 4, "solid, " + name,
            [&](Variant& v) { v.settings.mode = Mode::solid, v.closed_alone = true, change(v); });
    };
    for (const char* stage : stages)
        solid(fmt::format("no {}", stage), [&](Variant& v) { v.settings.skip.emplace_back(stage); });
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
    std::erase_if(all, [](const Variant& v) { return v.settings.exact != ExactLevel::predicates; });
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
