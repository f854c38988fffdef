#pragma once
#include <string>
#include <vector>

#include "clash/clashes.hpp"

namespace oncollide::tools {

/// Reads known pairs from a CSV file: two names or patterns per row, in either order. Further columns and text after
/// `#` are ignored, so a CSV report can be used; its resolved clashes do not count. Matching clashes become `ignored`.
/// Throws Error{bad_data} naming the row.
/// @param strict    throws Error{bad_data} if a row matches no pair of `clashes`
/// @param warnings  receives a line for each name or pattern that matches no part, and one for rows without a pair
void ignore_pairs(const std::string& file, const PartList& parts, bool strict, std::vector<Clash>& clashes,
                  std::vector<std::string>& warnings);

} // namespace oncollide::tools
