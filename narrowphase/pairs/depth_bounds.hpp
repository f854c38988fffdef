#pragma once
#include <oncollide/narrowphase/finding.hpp>
#include <oncollide/narrowphase/pairs/pair_task.hpp>
#include <oncollide/narrowphase/pairs/pair_worker.hpp>

namespace oncollide {

// Certified bounds on the depth of pairs of all kinds: Penetration::depth and depth_upper.

/// Bounds the depth of two bounded bodies that are not two terrains. A terrain is solid below its surface. The trees
/// must exist. Cost: one distance for a sphere or a capsule; for other bodies, locating up to some hundred points of
/// each in the other.
Penetration depth_of_bounded(PairWorker& worker, const PairTask& task);

/// Sets Penetration::parting_lower and the following of two bounded shapes.
void set_parting(const PairTask& task, Penetration& found);

/// An upper bound on the depth of two bounded bodies: the shortest translation found that parts them. A terrain is
/// solid without end below its surface, so only translations upward count.
/// @param normals  directions in the world frame to try besides the axes of the bodies and of the world; unit vectors
double parting_translation(const PairTask& task, std::span<const Eigen::Vector3d> normals = {});

} // namespace oncollide
