#pragma once
#include <optional>

#include <oncollide/narrowphase/finding.hpp>
#include <oncollide/narrowphase/pairs/pair_task.hpp>

namespace oncollide {

/// Decides whether a sphere meets a sphere, a box, a capsule or a cylinder, by the distance of its centre. The bodies
/// must be shapes of which at least one is no polytope. Nothing: there is no closed form, or rounding hides the result.
/// Cost: 15 to 25 ns.
std::optional<Finding> decide_by_centre(const PairTask& task, double clearance);

/// Decides whether a shape meets a half-space, by its lowest height. Nothing: rounding hides the result. Cost: 15 to 30
/// ns, and 1 ns for each point of a hull. @param swapped  true: the half-space is the task's b
std::optional<Finding> decide_by_height(const PairTask& task, bool swapped, double clearance);

/// Decides whether two shapes that are boxes meet, by their separating axes. Nothing: one is no box, or rounding hides
/// the result. Cost: 60 ns. @param depth  set to a lower bound of the depth of boxes that meet
std::optional<Finding> decide_by_axes(const PairTask& task, double clearance, double& depth);

} // namespace oncollide
