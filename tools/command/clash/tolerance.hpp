#pragma once
#include "clash/clashes.hpp"

namespace oncollide::tools {

/// True if two crossing parts certainly overlap by no more than the tolerance: the overlap is at most that thick, or
/// moving one part by the tolerance separates them (for parts that are not closed, separates the surfaces). False
/// proves nothing.
bool is_within_tolerance(const Clashes& found, const Clash& clash, double tolerance);

} // namespace oncollide::tools
