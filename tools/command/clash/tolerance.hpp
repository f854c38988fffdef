#pragma once
#include "clash/clashes.hpp"

namespace oncollide::tools {

/// True if two crossing parts, of which one is not closed, certainly overlap by no more than the tolerance: moving one
/// by it separates the surfaces. False proves nothing.
bool open_within_tolerance(const Clashes& found, const Clash& clash, double tolerance);

} // namespace oncollide::tools
