#pragma once
#include <span>
#include <string>
#include <vector>

#include <oncollide/pipeline/settings.hpp>

#include "truth/tally.hpp"
#include "verify/cases/body_case.hpp"

namespace oncollide::tools {

/// All bodies of all cases in one scene, as stored, each at its first pose. Most are near the origin, so bodies of one
/// case are hard for bodies of the others. The result hash must be equal for any number of threads and kind of broad
/// phase; with `gpu` also for gl-compute, in runs with spheres. The pair of each case must have the
/// same result as alone, also from Pairs::decide(). Throws Error{no_gpu} if `gpu` is requested
/// and there is none.
Tally try_crowd(const std::vector<BodyCase>& cases, Mode mode, std::span<const int> threads, bool gpu);

} // namespace oncollide::tools
