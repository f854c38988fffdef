#pragma once
#include <string>
#include <vector>

#include <oncollide/pipeline/settings.hpp>

#include "body_case.hpp"
#include "tally.hpp"

namespace oncollide::tools {

/// One way to run the pipeline.
struct Variant {
    std::string name;
    Settings settings;
    bool among_others = false; ///< with 70 static bodies far away, so that delimitation has something to reject
};

/// Plain, predicates and FCL on both kinds of spheres.
std::vector<Variant> plain_variants();
/// These with every set of stages left out, at two depths; and other algorithms, budgets, a clearance and company.
std::vector<Variant> all_variants();

/// Asks every variant about the case as it is; with the bodies swapped; with triangles, corners and vertices in another
/// order; after a motion of both that is exact; and after one that is rounded. Each answer and bound is held against
/// the truth of what was asked, each answer against that of the case as it is. What FCL decides may be wrong where FCL
/// is. Throws Error{internal} when the truth contradicts the case.
Tally try_bodies(const BodyCase& c, const std::vector<Variant>& variants);

} // namespace oncollide::tools
