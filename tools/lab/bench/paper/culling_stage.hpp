#pragma once
#include <memory>

#include <oncollide/narrowphase/gl/culling/pair_culling.hpp>
#include <oncollide/pipeline/world/stage.hpp>

namespace oncollide::tools {

/// A comparator in the place of the refine stage: it drops pairs of meshes, and all others stay undecided.
/// @param refine  the stage that it replaces, which lists the pairs
std::unique_ptr<Stage> make_culling_stage(std::unique_ptr<Stage> refine, std::unique_ptr<PairCulling> culling);

} // namespace oncollide::tools
