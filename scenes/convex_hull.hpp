#pragma once
#include <span>
#include <vector>

#include <oncollide/scenes/mesh.hpp>

namespace oncollide {

/// A convex polytope around a set of points.
struct Hull {
    std::vector<std::uint32_t> vertices; ///< indices into the input, ascending
    std::vector<Triangle> triangles;     ///< indices into the input, outward orientation; empty when the points are flat
    double slack = 0;                    ///< certified: every input point is within this distance (m) of the hull of `vertices`
};

/// Convex hull of finite `points` (at least one) by Qhull. Points that lie in a plane, on a line or in one spot, or that
/// Qhull gives up on, return every point as a vertex, no triangles and slack 0: still a superset of the hull's vertices.
///
/// The slack is proved after the fact, whatever Qhull did: with every point at most e outside the planes of the facets
/// and an interior point at depth d under all of them, scaling towards it by d/(d+e) brings each point into the hull,
/// so no point is farther out than e/d times the diagonal.
/// Cost: O(n log n) expected, plus O(points * facets) for the proof on points that Qhull left out.
Hull convex_hull(std::span<const Eigen::Vector3d> points);

} // namespace oncollide
