#include <fmt/format.h>

#include "body_trial.hpp"

namespace oncollide::tools {
namespace {

Variant variant(int depth, ExactLevel exact, Spheres spheres)
{
    Variant v;
    v.settings.depth = depth, v.settings.exact = exact, v.settings.spheres = spheres;
    v.name = fmt::format("depth {}, {} spheres, exact {}", depth, name_of(spheres), name_of(exact));
    return v;
}

} // namespace

std::vector<Variant> plain_variants()
{
    std::vector<Variant> all;
    for (ExactLevel exact : {ExactLevel::off, ExactLevel::predicates, ExactLevel::fcl})
        for (Spheres spheres : {Spheres::paper, Spheres::tight}) all.push_back(variant(6, exact, spheres));
    return all;
}

std::vector<Variant> all_variants()
{
    constexpr const char* stages[] = {"bounds", "delimitation", "broad", "ocst", "exact"};
    std::vector<Variant> all;
    for (int depth : {2, 7})
        for (ExactLevel exact : {ExactLevel::off, ExactLevel::predicates, ExactLevel::fcl})
            for (Spheres spheres : {Spheres::paper, Spheres::tight})
                for (unsigned skipped = 0; skipped < (exact == ExactLevel::off ? 16u : 32u); ++skipped) {
                    Variant& v = all.emplace_back(variant(depth, exact, spheres));
                    for (unsigned k = 0; k < 5; ++k)
                        if (skipped >> k & 1)
                            v.settings.skip.emplace_back(stages[k]), v.name += fmt::format(", no {}", stages[k]);
                }
    const auto add = [&](const char* name, auto change) {
        for (const Variant& plain : plain_variants()) {
            Variant v = plain;
            v.name += fmt::format(", {}", name);
            change(v);
            all.push_back(v);
        }
    };
    for (int depth : {1, 4, 10})
        add(fmt::format("at depth {}", depth).c_str(), [&](Variant& v) { v.settings.depth = depth; });
    add("octree", [](Variant& v) { v.settings.broad_phase = BroadPhaseKind::octree; });
    add("brute force", [](Variant& v) { v.settings.broad_phase = BroadPhaseKind::brute_force; });
    add("no coherence", [](Variant& v) { v.settings.coherence = false; });
    add("cells dropped at once", [](Variant& v) { v.settings.age_limit = 1; });
    add("20 cells", [](Variant& v) { v.settings.node_budget = 20; });
    add("no memory", [](Variant& v) { v.settings.memory_budget = 1; });
    add("among others", [](Variant& v) { v.among_others = true; });
    add("among others, octree",
        [](Variant& v) { v.among_others = true, v.settings.broad_phase = BroadPhaseKind::octree; });
    return all;
}

} // namespace oncollide::tools
