#pragma once
#include "clash/clashes.hpp"

namespace oncollide::tools {

/// Do two parts that cross overlap by no more than the tolerance: is what they have in common no thicker, or does a
/// shift of one of them by so much part them? Then it is certain; that neither was found says nothing.
bool is_within_tolerance(const Clashes& found, const Clash& clash, double tolerance);

} // namespace oncollide::tools
