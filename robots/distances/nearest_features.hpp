#pragma once
#include <oncollide/narrowphase/finding.hpp>
#include <oncollide/narrowphase/pairs/pair_task.hpp>

namespace oncollide {

/// False if the parts of the two bodies that are nearest to each other have more than one pair of nearest points: faces
/// or edges that are parallel, up to 1e-7 rad.
/// @param found   their distance, above 0
/// @param normal  unit, world frame: from a to b
bool have_one_nearest_pair(const PairTask& task, const Distance& found, const Eigen::Vector3d& normal);

} // namespace oncollide
