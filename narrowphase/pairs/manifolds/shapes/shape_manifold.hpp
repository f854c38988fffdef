#pragma once
#include <oncollide/narrowphase/finding.hpp>
#include <oncollide/narrowphase/pairs/pair_task.hpp>

namespace oncollide {

class PairWorker;

/// True if both bodies are shapes, at most one of them a half-space.
bool are_shapes(const PairTask& task);

/// The manifold of two shapes, in the order of the task (a half-space is first); world frame. One region or none. The
/// normal has the direction of the least translation that parts them; the points are the corners of the common part of
/// the two faces along it. Cost: 0.05 to 0.5 microseconds for spheres, capsules and boxes, 0.5 to 3 for other shapes.
void manifold_of_shapes(PairWorker& worker, const PairTask& task, const ManifoldOptions& options, Manifold& manifold);

} // namespace oncollide
