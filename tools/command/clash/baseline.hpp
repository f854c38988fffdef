#pragma once
#include <string>
#include <vector>

#include "clash/clashes.hpp"
#include "cli/lengths.hpp"

namespace oncollide::tools {

/// A clash of the baseline that no longer exists.
struct ResolvedClash {
    std::string id, a, b, kind, comment;
};

/// Compares with the JSON report of an earlier run. A clash that is also there becomes `active`, unless it got worse
/// (near, then touching, then a deeper kind) or had been resolved. Comments are taken over, and of active clashes a
/// status that a user wrote. Clashes have the same id there, or in a report without ids the same names of parts.
/// Returns all clashes of the baseline that do not exist now. Throws Error{bad_data}.
/// @param clearance  of this run, in `unit`
/// @param warnings   receives a line if the baseline's clearance is larger: pairs may then be resolved by it alone
std::vector<ResolvedClash> compare_with_baseline(const std::string& file, const PartList& parts, double clearance,
                                                 const Unit& unit, std::vector<Clash>& clashes,
                                                 std::vector<std::string>& warnings);

} // namespace oncollide::tools
