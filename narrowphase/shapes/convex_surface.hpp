#pragma once
#include <span>
#include <vector>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// The exact surface of the convex hull of finite `points`: closed, outward orientation, every point on it or inside. A
/// face with more than three corners is several triangles. Indices into `points`; empty if all lie in a plane.
///
/// Uses Qhull's facets if exact signs prove them right; otherwise adds points one by one, each exactly. Cost: O(n log
/// n) and O(points inside * facets); otherwise O(n * facets).
std::vector<Triangle> convex_surface(std::span<const Eigen::Vector3d> points);

} // namespace oncollide
