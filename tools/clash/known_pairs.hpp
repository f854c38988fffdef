#pragma once
#include <string>
#include <vector>

#include "clash/clashes.hpp"

namespace oncollide::tools {

/// Pairs that are meant to clash, from a CSV file: two names or patterns a row, in either order; more columns are for
/// the reader. `#` begins a comment. A CSV report will do. Clashes that one fits become ignored. Throws
/// Error{bad_data} naming the row.
/// @param warnings  gets a line for each row whose names no part has
void ignore_pairs(const std::string& file, const PartList& parts, std::vector<Clash>& clashes,
                  std::vector<std::string>& warnings);

/// A clash of the baseline that is none any more.
struct FixedClash {
    std::string a, b, kind;
};

/// Compares with the JSON report of an earlier run: what it has, too, is `same`, unless it got worse (near, then
/// touching, then crossing or enclosed). Returns what is fixed. Throws Error{bad_data}.
std::vector<FixedClash> compare_with_baseline(const std::string& file, const PartList& parts,
                                              std::vector<Clash>& clashes);

} // namespace oncollide::tools
