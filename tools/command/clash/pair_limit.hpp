#pragma once
#include "clash/clashes.hpp"

namespace oncollide::tools {

/// Throws Error{bad_data} if more than `settings.most_pairs` pairs of parts that are compared have overlapping AABBs. A
/// file of a kilobyte may place a hundred thousand parts at one point, whose five billion pairs no memory holds.
void check_number_of_pairs(const PartList& parts, const ClashSettings& settings);

} // namespace oncollide::tools
