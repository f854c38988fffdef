#pragma once
#include <cstdint>

#include "truth/tally.hpp"

namespace oncollide::tools {

constexpr const char* approach_family = "near bodies of all kinds";

/// `count` pairs of two bodies of all kinds, which approach each other to 1e-13 to 1e-2 m and then move by about the
/// gap that a World remembers: step() of a live World must say what decide() says, and distances must agree with
/// verdicts. Half of the bodies are upright or lean by 1e-15 to 1, where AABBs and roots of differences are easily
/// wrong. The pairs do not depend on the number of threads. Cost: about 1 ms per pair.
Tally try_approaches(std::uint64_t count, int threads);

} // namespace oncollide::tools
