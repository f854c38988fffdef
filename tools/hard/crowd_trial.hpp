#pragma once
#include <span>
#include <string>
#include <vector>

#include <oncollide/pipeline/settings.hpp>

#include "hard/body_case.hpp"
#include "hard/tally.hpp"

namespace oncollide::tools {

/// All bodies of all cases at once, as stored, each at its first pose: those of one case are hard for those of the
/// next, as most are in one place. The result hash must be the same for any number of threads and kind of broad phase;
/// with `gpu` also for gl-compute, on the pairs of plain spheres. The pair of each case must come out as exactly as
/// alone, and so it must from MeshQueries, which know no solids. Throws Error{no_gpu} when `gpu` is requested and there
/// is none.
Tally try_crowd(const std::vector<BodyCase>& cases, Mode mode, std::span<const int> threads, bool gpu);

} // namespace oncollide::tools
