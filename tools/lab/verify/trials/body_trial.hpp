#pragma once
#include <string>
#include <vector>

#include "truth/setting_variants.hpp"
#include "truth/tally.hpp"
#include "verify/cases/body_case.hpp"

namespace oncollide::tools {

/// A way to run the pipeline on a case.
struct Variant : SettingVariant {
    bool among_others = false; ///< with 70 static bodies far away, so that delimitation can reject something
    bool closed_alone = false; ///< only for cases in which a mesh has an inside
    double of_size = 0;        ///< the clearance, in diagonals of the larger body
    double of_distance = 0;    ///< or in multiples of the bodies' distance at the first pose where they are apart
};

/// No exact level, predicates and FCL with both bounding volumes: with each set of stages skipped, at two depths; with
/// other algorithms, budgets and more bodies; with small and large clearances, slightly below, at and above the
/// distance; as solids; and with kinds of contact requested.
std::vector<Variant> all_variants();

/// Runs every variant on the case in all its forms. Checks each verdict, kind and bound against the truth, and each
/// verdict against the verdict of the case as stored. A mesh without an inside must be refused as a solid, and is then
/// treated as a surface. A result of FCL may be wrong where FCL is wrong. Throws Error{internal} if the truth
/// contradicts the case.
Tally try_bodies(const BodyCase& c, const std::vector<Variant>& variants);

} // namespace oncollide::tools
