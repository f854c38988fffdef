#pragma once
#include <optional>

#include <oncollide/base/function_ref.hpp>
#include <oncollide/narrowphase/inside/point_location.hpp>
#include <oncollide/narrowphase/model.hpp>
#include <oncollide/narrowphase/pairs/pair_task.hpp>

namespace oncollide {

class PairWorker;

/// False if no part of the inner body can be inside the outer one, which has a surface mesh.
bool may_hold(const Model& outer, const Eigen::Isometry3d& pose_outer, const Model& inner,
              const Eigen::Isometry3d& pose_inner);

/// A point of the inner body inside the outer one's mesh, in the inner body's frame. Requires that their surfaces do
/// not meet.
/// @param tree  the tree of the mesh; null: test all triangles
std::optional<Eigen::Vector3d> held_point(const PairTask& task, bool outer_is_a, const Mesh& mesh, ObbTree* tree,
                                          PointLocator& locator);

/// A point (world frame) of a part of one body that lies inside the other. Requires that their surfaces do not meet.
/// @param around  returns the surface that bounds a model's inside; null: the model has no inside
std::optional<Eigen::Vector3d> one_holds_the_other(const PairTask& task, PointLocator& locator,
                                                   FunctionRef<ObbTree*(const Model&)> around);

/// True if a box or a hull of the pair encloses a part of the other body. Requires that their surfaces do not meet.
bool polytope_holds(PairWorker& worker, const PairTask& task);

} // namespace oncollide
