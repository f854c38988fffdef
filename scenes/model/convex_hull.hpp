#pragma once
#include <span>
#include <vector>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// A convex polytope around a set of points.
struct Hull {
    std::vector<std::uint32_t> vertices; ///< indices into the input, ascending
    std::vector<Triangle> triangles; ///< indices into the input, outward orientation; empty when the points are flat
    double slack = 0; ///< certified: every input point is within this distance (m) of the hull of `vertices`
};

/// Convex hull of finite `points` (at least one) by Qhull. Points that lie in a plane, on a line or in one spot, or
/// that Qhull gives up on (thinner than about 1e-10 of their size), return every point as a vertex, no triangles and
/// slack 0: still a superset of the hull's vertices.
///
/// The slack is proved after the fact, whatever Qhull did: each point that is no vertex is written as a combination of
/// an inner point and the corners of the facet that it lies under, with shares >= 0 and a sum <= 1, so of a point
/// certainly in the hull; what is missing to the point is the slack (rounding included). Facets are found by walking
/// from one to the next. With every point a vertex it is 0. Cost: O(n log n) expected, plus the walks: O(points *
/// sqrt(facets)), less for points in a mesh's order.
Hull convex_hull(std::span<const Eigen::Vector3d> points);

} // namespace oncollide
