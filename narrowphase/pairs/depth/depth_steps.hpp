#pragma once
#include <utility>

#include <Eigen/Geometry>

#include <oncollide/base/numbers/infinity.hpp>
#include <oncollide/narrowphase/pairs/depth_bounds.hpp>

namespace oncollide::depth_bounds {

// The steps of depth_of_bounded().

constexpr double rigid = 0x1p-18; ///< as in walk_tests.hpp

struct Side {
    Model& model;
    const Eigen::Isometry3d& pose;
};

/// True if p, in the terrain's frame, is certainly below its surface.
bool is_below(const Terrain& terrain, TerrainTree& tree, const Eigen::Vector3d& p, double margin);

/// A lower bound on the distance of a point (world frame) of the other body from the surface of this one; 0 or negative
/// if the point may be outside.
double depth_in(PairWorker& worker, const Side& outer, const Eigen::Vector3d& point);

bool is_ball_or_capsule(const Model& model);

/// If the core of a sphere or a capsule is outside the other body, the depth is the radius less their distance: a point
/// of the other body is that deep in the sphere, and no point of the sphere is deeper in the other body, because the
/// way to the core leaves it. If the core is inside, this bounds the depth.
/// @returns whether the depth is known
bool by_core(PairWorker& worker, const Side& round, const Side& other, bool round_is_a, Penetration& found);

} // namespace oncollide::depth_bounds
