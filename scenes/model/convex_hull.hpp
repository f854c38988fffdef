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

/// Convex hull of finite `points` (at least one) by Qhull. For points in a plane, on a line or at one position, and if
/// Qhull gives up (thinner than about 1e-10 of their size), every point is a vertex, there are no triangles and the
/// slack is 0: still a superset of the hull's vertices.
///
/// The slack is proved afterwards, independent of Qhull: each point that is not a vertex is written as a combination of
/// an inner point and the corners of the facet above it, with weights >= 0 and a sum <= 1, which is certainly in the
/// hull; the remaining distance to the point is the slack (rounding included). It is 0 if every point is a vertex.
/// Facets are found by walking from each to a neighbour. Cost: O(n log n) expected, plus the walks: O(points *
/// sqrt(facets)), less for points in a mesh's order.
Hull convex_hull(std::span<const Eigen::Vector3d> points);

} // namespace oncollide
