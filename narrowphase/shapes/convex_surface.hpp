#pragma once
#include <span>
#include <vector>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// The surface of the convex hull of finite `points`, exactly: closed, outward orientation, every point on it or
/// inside. Faces in one plane are several triangles. Indices into `points`; empty when all lie in a plane.
///
/// Qhull's facets where exact signs prove them right; else points are added one by one, each exactly.
/// Cost: O(n log n) and O(points inside * facets); else O(n * facets).
std::vector<Triangle> convex_surface(std::span<const Eigen::Vector3d> points);

} // namespace oncollide
