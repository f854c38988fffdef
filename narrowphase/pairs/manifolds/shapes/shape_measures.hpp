#pragma once
#include <oncollide/narrowphase/exact/relative_pose.hpp>
#include <oncollide/narrowphase/finding.hpp>
#include <oncollide/narrowphase/pairs/manifolds/shapes/few_points.hpp>
#include <oncollide/narrowphase/pairs/pair_task.hpp>

namespace oncollide {

/// True if one of two shapes, of which a may be a half-space, is inside the other. Rims and ellipsoids are sampled.
bool holds_other(const PairTask& task, const RelativePose& b_to_a);

/// Sets area, volume and centre of a region, in the world frame. Area and volume are known for two
/// polytopes and for a polytope in a half-space; they are 0 for round shapes.
/// @param points  all points of the region
/// @param normal  in a's frame
void measure_region(const PairTask& task, const RelativePose& b_to_a, std::span<const FewPoints::Candidate> points,
                    const Eigen::Vector3d& normal, ManifoldRegion& region);

/// An upper bound of the distance of any common point of both bodies from the hull of a region's points.
double lost_of_shapes(const PairTask& task, const RelativePose& b_to_a, std::span<const ManifoldPoint> points);

} // namespace oncollide
