#pragma once
#include <string>
#include <vector>

#include "hard/body_case.hpp"
#include "hard/tally.hpp"
#include "study/setting_variants.hpp"

namespace oncollide::tools {

/// One way to run the pipeline on a case.
struct Variant : SettingVariant {
    bool among_others = false; ///< with 70 static bodies far away, so that delimitation has something to reject
    bool closed_alone = false; ///< only for cases of which a mesh has an inside
    double of_size = 0;        ///< the clearance, in diagonals of the larger body
    double of_distance = 0;    ///< or in distances of the bodies at the first pose at which they are apart
};

/// Plain, predicates and FCL on both kinds of spheres: with every set of stages left out, at two depths; with other
/// algorithms, budgets and company; with clearances small and large, just less and more than the distance, and the
/// same; as solids; and with kinds of contact requested.
std::vector<Variant> all_variants();

/// Runs every variant on the case in all its forms. Each verdict, kind and bound is held against the truth of what
/// was requested, and each verdict against that of the case as it is. A mesh without an inside must be refused as a
/// solid, and is then taken as a surface. What FCL decides may be wrong where FCL is. Throws Error{internal} when the
/// truth contradicts the case.
Tally try_bodies(const BodyCase& c, const std::vector<Variant>& variants);

} // namespace oncollide::tools
