#pragma once
#include <oncollide/narrowphase/finding.hpp>
#include <oncollide/narrowphase/pairs/pair_task.hpp>

namespace oncollide {

class PairWorker;

/// The manifold of two round solids, in the order and the frame of the task: the direction of the deepest overlap, the
/// point there, and for two parallel lines their ends.
void manifold_of_solids(PairWorker& worker, const PairTask& task, const ManifoldOptions& options, Manifold& manifold);

} // namespace oncollide
