#pragma once
#include <array>
#include <optional>
#include <span>
#include <vector>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

// Proofs about a convex hull that was computed without guarantees. Private to scenes.

/// Returns, for each triangle, the three triangles across the edges opposite its corners; empty unless every edge is
/// shared by exactly two triangles that traverse it in opposite directions.
std::optional<std::vector<std::array<std::uint32_t, 3>>> neighbours_of(std::span<const Triangle> triangles);

/// The mean of the points at `vertices`, within a few ulp: a point of their hull.
Eigen::Vector3d mean_of(std::span<const Eigen::Vector3d> points, std::span<const std::uint32_t> vertices);

/// Upper bound on the distance of any of `points` to the hull of the points at `vertices`; rounding included.
/// `triangles` is an approximate closed surface of that hull: it only guides the proof.
double prove_slack(std::span<const Eigen::Vector3d> points, std::span<const std::uint32_t> vertices,
                   std::span<const Triangle> triangles, std::span<const std::array<std::uint32_t, 3>> neighbours);

} // namespace oncollide
