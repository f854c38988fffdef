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

/// Compares with the JSON report of an earlier run. A clash that is also in the baseline becomes `active`, unless it
/// got worse (near, then touching, then a deeper kind) or had been resolved. It takes over comments, and for active
/// clashes the status that a user wrote. Two clashes are the same if they have the same id or, in a report without ids,
/// the same names of parts. Returns all clashes of the baseline that do not exist now. Throws Error{bad_data}.
/// @param clearance  the clearance of this run, in `unit`
/// @param warnings   receives a line if the baseline's clearance is larger, because that alone may resolve pairs
std::vector<ResolvedClash> compare_with_baseline(const std::string& file, const PartList& parts, double clearance,
                                                 const Unit& unit, std::vector<Clash>& clashes,
                                                 std::vector<std::string>& warnings);

} // namespace oncollide::tools
